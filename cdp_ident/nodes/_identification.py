"""One identification from the command line's request to the files of its report, without ROS."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import Settings
from cdp_ident.identification.genetic_search import Progress
from cdp_ident.nodes._interruption import GivenUpError, Interruption
from cdp_ident.report.contents import Section, report
from cdp_ident.report.curves import Curves, curves
from cdp_ident.report.curves_file import curves_npz
from cdp_ident.report.fitted import fitted_yaml
from cdp_ident.report.folder import (
    CURVES,
    FIGURES,
    FITTED,
    PAGE,
    REPORT,
    TEXT,
    check_folder,
    json_text,
    write_files,
)
from cdp_ident.report.job import Job, LoadedJob, load, run
from cdp_ident.report.pictures import draw, write_pictures
from cdp_ident.report.progress import SearchDisplay
from cdp_ident.report.terminal import print_report

NODE_NAME = "identify"
DEFAULT_FOLDER = Path("identification")


@dataclass(frozen=True)
class Request:
    """What the command line asks for."""

    bags: tuple[Path, ...]
    holdout: tuple[Path, ...]
    out: Path | None
    method: str | None
    seed: int | None
    config: Path | None
    force: bool


class Identifier:
    """Identifies what was requested, as often as asked, into the same folder."""

    def __init__(self, request: Request, output: Console, progress: Console) -> None:
        self._request, self._output, self._progress = request, output, progress
        self._folder = request.out
        self._may_replace = request.force

    def load(self, given: Mapping[str, Any]) -> LoadedJob:
        """Read the configuration and the bags; `given` is what ROS was told.

        Raises `CdpIdentError` for whatever is wrong with them, and for a folder that holds a report already.
        """
        request = self._request
        values = read_parameter_file(request.config, NODE_NAME) if request.config else {}
        values |= given
        values |= {name: told for name in ("method", "seed") if (told := getattr(request, name)) is not None}
        loaded = load(Job(request.bags, request.holdout, Settings.of(values)))
        self._folder = self._folder or DEFAULT_FOLDER / loaded.fit[0].name
        check_folder(self._folder, self._may_replace)
        return loaded

    def finish(self, loaded: LoadedJob, interruption: Interruption) -> Section:
        """Identify, write the report's files, print it, and return it.

        An interruption ends the search, not the identification. Raises `CdpIdentError`, and `GivenUpError` where the
        identification was given up.
        """
        assert self._folder is not None
        with SearchDisplay(self._progress, loaded.job.settings.identify.search.generations) as display:

            def stop(progress: Progress) -> str | None:
                if interruption.given_up:
                    raise GivenUpError
                display.show(progress)
                if not interruption.asked:
                    return None
                display.say("the search ends here; its best so far is refined (Ctrl-C again ends at once)")
                return "interrupted"

            with interruption.searching():
                outcome = run(loaded, stop, display.say, lambda: interruption.asked or interruption.given_up)
        if interruption.given_up:
            raise GivenUpError
        content, drawn_from = report(outcome), curves(outcome)
        # What took long to find is safe before it is drawn.
        write_files(
            self._folder,
            {REPORT: json_text(content), FITTED: fitted_yaml(content), CURVES: curves_npz(drawn_from)},
        )
        self._may_replace = True
        print_report(self._output, content)
        self._output.print(f"{self._folder / REPORT} and {FITTED} are written", highlight=False, markup=False)
        self._draw(self._folder, content, drawn_from)
        return content

    def _draw(self, folder: Path, content: Section, drawn_from: Curves) -> None:
        """Draw the report; a failure is told, and takes nothing of the result."""
        try:
            write_pictures(folder, draw(content, drawn_from))
        except Exception as error:  # noqa: BLE001 - whatever it is, the parameters are to be served
            reason = " ".join(str(error).split()) or type(error).__name__
            said = f"no pictures: {reason}; once that is mended, `ros2 run cdp_ident report {folder}` draws them"
        else:
            said = f"{folder / PAGE} shows it all, {TEXT} and {FIGURES}/ as files"
        self._output.print(said, highlight=False, markup=False, soft_wrap=True)
