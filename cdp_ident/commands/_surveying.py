# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From folders to a survey, shown while it is made, for `survey`."""

import argparse
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from cdp_ident.configuration.settings import Settings, without_results
from cdp_ident.errors import FitFailedError, OptionError
from cdp_ident.machine.parallel import core_count
from cdp_ident.output_folder import alone_in, check_folder, json_text, write_files
from cdp_ident.outside_text import shown
from cdp_ident.pipeline.identifier import read_configuration
from cdp_ident.report.document import print_chapter, wide_console
from cdp_ident.report.schema import Section
from cdp_ident.survey.contents import survey
from cdp_ident.survey.page import chapter, survey_html, verdict
from cdp_ident.survey.run import PIECES, Finished, Plan, conduct, plan
from cdp_ident.survey.workers import cluster, processes

PAGE, CONTENTS = "survey.html", "survey.json"
_LONGEST_LINE = 300


def conduct_survey(options: argparse.Namespace) -> None:
    """Survey the bags. Raises CdpIdentError where that is not possible, or a piece has no result."""
    given, passed_over = without_results(read_configuration(options.config))
    if passed_over:
        print(passed_over)
    settings = Settings.of(given)
    check_folder(options.out, force=True)
    planned = plan(options.folders, options.out, options.by, given, options.force)
    console = wide_console()
    count = min(options.workers or core_count(), max(1, len(planned.left)))
    workers = cluster(options.scheduler) if options.scheduler else processes(count)
    where = options.scheduler or f"{count} process{'' if count == 1 else 'es'}"
    place = options.out / PIECES
    place.mkdir(parents=True, exist_ok=True)
    try:
        with alone_in(place, wait=False):
            came = _conduct(planned, workers, where)
    except BlockingIOError as error:
        raise OptionError(f"another survey writes into {place}: wait for it, or give another --out") from error
    everything = {**planned.done, **{piece.folder: piece for piece in came}}
    content = survey([everything[task.folder] for task in planned.tasks], options.by, settings, planned.left_out)
    print_chapter(console, chapter(content))
    console.print(verdict(content), style="bold", soft_wrap=True)
    _write(options.out, content, console)
    without = sum(bool(piece.problem) for piece in everything.values())
    if without:
        raise FitFailedError(f"{without} of {len(planned.tasks)} pieces have no result; {options.out / PAGE} tells why")


def _conduct(planned: Plan, workers: AbstractContextManager[Executor], where: str) -> list[Finished]:
    """Do what is left, and show how far it is; what is finished is kept whatever happens."""
    console = Console(stderr=True, highlight=False, markup=False)
    total, kept = len(planned.tasks), len(planned.done)
    bags = sum(len(task.piece.bags) for task in planned.tasks)
    console.print(f"{bags} bags in {total} pieces, {kept} of them kept from before", soft_wrap=True)
    if not planned.left:
        return []
    place = shown(planned.left[0].folder.parent)
    console.print(f"the others are identified by {where}; {place} keeps what is finished", soft_wrap=True)
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
    """Write the numbers, then the page."""
    write_files(out, {CONTENTS: json_text(content)}, instead_of=(CONTENTS, PAGE))
    write_files(out, {PAGE: survey_html(content)})
    place = shown(out)
    more = f"{place}/{PAGE} shows it all, {place}/{PIECES}/ has a report of each piece"
    console.print(f"{place}/{CONTENTS} is written; {more}", soft_wrap=True)
