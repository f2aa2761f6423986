"""One identification from the command line's request to the files of its report, without ROS."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from cdp_ident.bag.watched_folder import WatchedFolder
from cdp_ident.configuration.fitted_model import fitted_yaml
from cdp_ident.configuration.keys import KEYS
from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import Settings
from cdp_ident.diagnosis.new_trial import NewTrialCheck, check_new_trial
from cdp_ident.errors import CdpIdentError
from cdp_ident.pipeline.interruption import GivenUpError, Interruption
from cdp_ident.pipeline.job import load, run
from cdp_ident.report.contents import Section, report
from cdp_ident.report.curves import Curves, curves
from cdp_ident.report.curves_file import curves_npz
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
from cdp_ident.report.outcome import Job, LoadedJob, Outcome
from cdp_ident.report.pictures import draw, write_pictures
from cdp_ident.report.progress import SearchDisplay
from cdp_ident.report.terminal import print_report
from cdp_ident.search.genetic_search import Progress
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.trial import Trial

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
    watch: Path | None = None
    """Folder whose bags are fitted too, as they come."""


class Identifier:
    """Identifies what was requested, as often as asked, into the same folder."""

    def __init__(self, request: Request, output: Console, progress: Console) -> None:
        self._request, self._output, self._progress = request, output, progress
        self._folder = request.out
        self._may_replace = request.force
        self._watched = WatchedFolder(request.watch) if request.watch else None
        self._came: list[Path] = []
        """Bags of the watched folder that are fitted too."""
        self._latest: Outcome | None = None
        self._unseen: list[NewTrialCheck] = []

    def settings(self, given: Mapping[str, Any]) -> Settings:
        """Read the configuration; `given` is what ROS was told.

        Raises `CdpIdentError` for whatever is wrong with it.
        """
        request = self._request
        values = read_parameter_file(request.config, NODE_NAME).taken(KEYS.__contains__) if request.config else {}
        values |= given
        values |= {name: told for name in ("method", "seed") if (told := getattr(request, name)) is not None}
        return Settings.of(values)

    @property
    def waits_for(self) -> Path | None:
        """The folder whose bags are waited for, where none is given to begin with."""
        return None if self._request.bags else self._request.watch

    @property
    def has_new(self) -> bool:
        """Whether a bag has come into the watched folder that was not there at the last identification."""
        return self._watched is not None and bool(self._watched.new())

    def load(self, given: Mapping[str, Any]) -> LoadedJob:
        """Read the configuration and the bags; `given` is what ROS was told.

        Raises `CdpIdentError` for whatever is wrong with them, and for a folder that holds a report already.
        """
        settings = self.settings(given)
        if self._watched:
            self._take_new(self._watched, settings)
        loaded = load(Job((*self._request.bags, *self._came), self._request.holdout, settings))
        name = self._request.watch.resolve().name if self._request.watch else loaded.fit[0].name
        self._folder = self._folder or DEFAULT_FOLDER / name
        check_folder(self._folder, self._may_replace)
        return loaded

    def _take_new(self, watched: WatchedFolder, settings: Settings) -> None:
        """Add the new bags of the watched folder, each judged as unseen first; one without a trial is left out."""
        for bag in watched.new():
            watched.take(bag)
            try:
                trial = load_trial(bag, settings.trial)
                if self._latest:
                    self._judge(self._latest, trial)
            except CdpIdentError as error:
                self._say(f"{bag} is left out: {' '.join(str(error).split())}")
            else:
                self._came.append(bag)

    def _judge(self, latest: Outcome, trial: Trial) -> None:
        after = latest.trace.after
        expected = latest.trace.errors[1].rmse
        window = latest.identification.data.window
        unseen = check_new_trial(after.model, after.fit.values, latest.trace.covariance, expected, trial, window)
        self._unseen.append(unseen)
        self._say(unseen.words)

    def _say(self, sentence: str) -> None:
        self._output.print(sentence, highlight=False, markup=False, soft_wrap=True)

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
        self._latest = outcome
        content, drawn_from = report(outcome, self._unseen), curves(outcome)
        # What took long to find is safe before it is drawn.
        write_files(
            self._folder,
            {REPORT: json_text(content), FITTED: fitted_yaml(content), CURVES: curves_npz(drawn_from)},
        )
        self._may_replace = True
        print_report(self._output, content)
        self._say(f"{self._folder / REPORT} and {FITTED} are written")
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
        self._say(said)
