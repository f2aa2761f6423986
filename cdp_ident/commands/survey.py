"""Identifies the bags of many rigs and days, and tells what changed and which rig differs."""

from concurrent.futures import Executor
from contextlib import AbstractContextManager
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.configuration.settings import Settings, without_results
from cdp_ident.errors import FitFailedError, OptionError, ReportError
from cdp_ident.machine.parallel import core_count
from cdp_ident.outside_text import shown
from cdp_ident.pipeline.identifier import read_configuration
from cdp_ident.report.folder import check_folder, clean_folder, json_text, write_files
from cdp_ident.report.schema import Section
from cdp_ident.report.terminal import print_tables
from cdp_ident.survey.contents import survey
from cdp_ident.survey.identification import Finished
from cdp_ident.survey.run import PIECES, Plan, conduct, plan
from cdp_ident.survey.tables import problems, tables, verdict
from cdp_ident.survey.workers import cluster, processes

DESCRIPTION = """\
Identify the bags of many rigs and days, and look at them together: parameters and effects over time with 95 %
intervals, when something changed, which rig differs from the others and in what.

Bags are looked for in folders and below them, and grouped by the rig whose name the recorder wrote; one without a name
is of the rig of the other bags in its folder, or else of one called as the folder. Each day of a rig, or each bag, is a
piece that is identified as `identify --once` does, in processes on this machine or on a Dask cluster; the result is the
same however many there are. A worker that dies costs its own piece alone, which is tried once more.

Each piece has a report of its own below DIR/pieces, as soon as it is finished. After Ctrl-C, or when bags came or
changed, the same command does what is missing. Then DIR/survey.html and survey.json are written."""

EPILOG = """\
examples:
  ros2 run cdp_ident survey trials --config rig.yaml
  ros2 run cdp_ident survey trials --by bag --workers 8 --out surveys/course
  ros2 run cdp_ident survey /shared/trials --scheduler tcp://10.0.0.1:8786 --out /shared/survey

Exit codes: 0 done; 3 the survey is written, but a piece has no result; 2 bad input; 130 interrupted."""

PAGE, CONTENTS = "survey.html", "survey.json"
_WIDTH = 140
"""Where there is no terminal."""
_LONGEST_LINE = 300


@entry_point
def main(arguments: list[str]) -> int:
    """Survey the bags."""
    options = _parser().parse_args(arguments)
    if options.scheduler and options.workers is not None:
        raise OptionError("--workers are on this machine, --scheduler has its own: give one of the two")
    if options.workers is not None and options.workers < 1:
        raise OptionError(f"--workers is {options.workers}: expected 1 or more")
    given, passed_over = without_results(read_configuration(options.config))
    if passed_over:
        print(passed_over)
    settings = Settings.of(given)
    check_folder(options.out, force=True)
    planned = plan(options.folders, options.out, options.by, given, options.force)
    console = Console(highlight=False, markup=False)
    console = console if console.is_terminal else Console(highlight=False, markup=False, width=_WIDTH)
    count = min(options.workers or core_count(), max(1, len(planned.left)))
    workers = cluster(options.scheduler) if options.scheduler else processes(count)
    came = _conduct(planned, workers, options.scheduler or f"{count} process{'' if count == 1 else 'es'}")
    everything = {**planned.done, **{piece.folder: piece for piece in came}}
    content = survey([everything[task.folder] for task in planned.tasks], options.by, settings, planned.left_out)
    print_tables(console, [*tables(content), *([failed] if (failed := problems(content)).rows else [])])
    console.print(verdict(content), style="bold", soft_wrap=True)
    _write(options.out, content, console)
    without = sum(bool(piece.problem) for piece in everything.values())
    if without:
        raise FitFailedError(f"{without} of {len(planned.tasks)} pieces have no result; {options.out / PAGE} tells why")
    return 0


def _conduct(planned: Plan, workers: AbstractContextManager[Executor], where: str) -> list[Finished]:
    """Do what is left, and show how far it is; what is finished is kept whatever happens."""
    console = Console(stderr=True, highlight=False, markup=False)
    total, kept = len(planned.tasks), len(planned.done)
    bags = sum(len(task.piece.bags) for task in planned.tasks)
    console.print(f"{bags} bags in {total} pieces, {kept} of them kept from before", soft_wrap=True)
    if not planned.left:
        return []
    console.print(
        f"the others are identified by {where}; {planned.left[0].folder.parent} keeps what is finished", soft_wrap=True
    )
    came: list[Finished] = []
    try:
        with workers as executor, Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task("identifying", total=total, completed=kept)
            for piece in conduct(planned, executor):
                came.append(piece)
                said = piece.problem or (piece.report or {}).get("verdict", "")
                about = f"{kept + len(came)} of {total}: {piece.piece.rig}, {piece.piece.name}: {said}"
                console.print(shown(about, _LONGEST_LINE), soft_wrap=True)
                bar.update(task, completed=kept + len(came))
    except KeyboardInterrupt:
        console.print(f"{kept + len(came)} of {total} pieces are kept; the same command goes on", soft_wrap=True)
        raise
    return came


def _write(out: Path, content: Section, console: Console) -> None:
    """Write the numbers, then the page; where it cannot be drawn, one line says why."""
    clean_folder(out)
    write_files(out, {CONTENTS: json_text(content)}, instead_of=(CONTENTS, PAGE))
    from cdp_ident.survey.page import survey_html  # noqa: PLC0415 - only who draws waits for what draws to be loaded

    try:
        write_files(out, {PAGE: survey_html(content)})
    except ReportError as error:
        console.print(f"{out / CONTENTS} is written; {shown(error)}", soft_wrap=True)
    else:
        console.print(
            f"{out / CONTENTS} is written; {out / PAGE} shows it all, {out / PIECES}/ has a report of each piece",
            soft_wrap=True,
        )


def _parser() -> ArgumentParser:
    parser = ArgumentParser("survey", DESCRIPTION, EPILOG)
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders with bags in them or below them")
    parser.add_argument("--by", choices=("day", "bag"), default="day", help="what is identified together (day)")
    parser.add_argument("--workers", type=int, metavar="N", help="processes on this machine (one for each core)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster, such as tcp://10.0.0.1:8786")
    parser.add_argument("--out", type=Path, default=Path("survey"), metavar="DIR", help="where all of it goes (survey)")
    parser.add_argument("--force", action="store_true", help="identify every piece anew, those kept from before too")
    parser.add_argument("--config", type=Path, metavar="FILE", help="ROS parameter file, as for identify")
    return parser
