# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""One piece of a survey, identified as `identify --once` does, and what is kept of it."""

import io
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from cdp_ident.bag.reader import bag_name
from cdp_ident.configuration.settings import Settings, given_for
from cdp_ident.errors import BagError, CdpIdentError, FitFailedError, OptionError, ReportError, TrialError
from cdp_ident.files import read_regular
from cdp_ident.outside_text import shown
from cdp_ident.pipeline.identifier import Identifier, Request
from cdp_ident.pipeline.interruption import Interruption
from cdp_ident.report.folder import REPORT, json_text, write_files
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section
from cdp_ident.survey.pieces import LeftOut, Piece
from cdp_ident.trial.load import load_trial

RECORD = "piece.json"
"""Is beside the report of a finished piece, and says from what it was made."""
_SCHEMA = "cdp_ident/piece/1"
_LARGEST = 1 << 20
_LONGEST_PROBLEM = 400


@dataclass(frozen=True)
class Task:
    """A piece, and what a worker needs to know to identify it."""

    piece: Piece
    folder: Path
    """Where its report goes; absolute."""
    given: Mapping[str, Any]
    """The configuration, by name."""
    key: str
    """Of everything that its result depends on."""


@dataclass(frozen=True)
class Finished:
    """The result of a piece."""

    piece: Piece
    folder: Path
    report: Section | None
    """The contents of its `report.json`; None where there is no result."""
    left_out: tuple[LeftOut, ...] = ()
    """Bags of it that hold no trial."""
    problem: str = ""
    """Why its parameters mean nothing, or there are none."""


def identify_piece(task: Task) -> tuple[Path, str]:
    """Identify a piece into its folder, in whatever process; return that, and why there is no result, if so."""
    try:
        _identify(task)
    except CdpIdentError as error:
        return task.folder, shown(error, _LONGEST_PROBLEM)
    except Exception as error:  # noqa: BLE001 - whatever it is, the other pieces go on
        return task.folder, shown(f"{type(error).__name__}: {error}", _LONGEST_PROBLEM)
    return task.folder, ""


def _identify(task: Task) -> None:
    _forget(task.folder)
    usable, left_out = _usable(task)
    names = [bag_name(bag) for bag in usable]
    quiet = Console(file=io.StringIO())
    request = Request(usable, (), task.folder, method=None, seed=None, config=None, force=True)
    identifier = Identifier(request, quiet, quiet)
    result = identifier.identify(identifier.load(given_for(task.given, names)), Interruption())
    try:
        identifier.write(result)
    except FitFailedError:
        if not result.failure:
            raise
    record = {
        "schema": _SCHEMA,
        "key": task.key,
        "failure": result.failure,
        "left_out": [asdict(bag) for bag in left_out],
    }
    write_files(task.folder, {RECORD: json_text(record)})


def _forget(folder: Path) -> None:
    """Remove the record that the piece is finished while its report is replaced."""
    try:
        (folder / RECORD).unlink(missing_ok=True)
    except OSError as error:
        raise OptionError(f"{folder} cannot be written: {error.strerror or error}") from error


def _usable(task: Task) -> tuple[tuple[Path, ...], list[LeftOut]]:
    """Return the bags of a piece that hold a trial, and the others."""
    usable, left_out = [], []
    options = Settings.of(task.given).trial
    for bag in task.piece.bags:
        try:
            load_trial(bag.path, options)
        except (BagError, TrialError) as error:
            left_out.append(LeftOut(str(bag.path), shown(error, _LONGEST_PROBLEM)))
        else:
            usable.append(bag.path)
    if not usable:
        raise TrialError(f"no bag of it holds a trial: {left_out[0].reason}")
    return tuple(usable), left_out


def finished(task: Task) -> Finished | None:
    """Return the result of a task; None where it is not finished, or its bags or configuration have changed since."""
    try:
        record = json.loads(read_regular(task.folder / RECORD, _LARGEST))
        if (record["schema"], record["key"]) != (_SCHEMA, task.key):
            return None
        left_out = tuple(LeftOut(shown(bag["bag"]), shown(bag["reason"])) for bag in record["left_out"])
        report = read_report(task.folder / REPORT)
        return Finished(task.piece, task.folder, report, left_out, shown(record["failure"]))
    except (OSError, ValueError, RecursionError, KeyError, TypeError, ReportError):
        return None
