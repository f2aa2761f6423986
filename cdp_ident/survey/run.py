# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A survey from folders to finished pieces: bags are grouped by rig, and a rig's bags into pieces.

A piece is identified as `identify --once` does; a record beside its report says from what it was made. What is there
already is kept, the rest goes to the workers.
"""

import hashlib
import io
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field
from datetime import datetime
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from rich.console import Console

from cdp_ident.bag.folders import bags_below
from cdp_ident.bag.metadata import Metadata
from cdp_ident.bag.reader import bag_checksums, bag_name, read_joint_states
from cdp_ident.configuration.settings import Settings, given_for
from cdp_ident.errors import BagError, CdpIdentError, FitFailedError, OptionError, ReportError, TrialError
from cdp_ident.files import read_regular
from cdp_ident.output_folder import json_text, write_files
from cdp_ident.outside_text import shown
from cdp_ident.pipeline.identifier import Identifier, Request
from cdp_ident.pipeline.interruption import Interruption
from cdp_ident.report.folder import REPORT
from cdp_ident.report.provenance import versions
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section
from cdp_ident.survey.workers import each
from cdp_ident.trial.load import load_trial
from cdp_ident.user_input import refuse_unknown

By = Literal["day", "bag"]
NamedBy = Literal["recorder", "neighbours", "folder"]
"""Who says of which rig a bag is: its recorder, the recorder of the others in its folder, or the folder's name."""

PIECES = "pieces"
"""The folder with a folder for each piece."""
RECORD = "piece.json"
"""The record of a finished piece."""
_SCHEMA = "cdp_ident/piece/1"
_LARGEST = 1 << 20
_LONGEST_NAME, _LONGEST_PROBLEM = 60, 400


@dataclass(frozen=True)
class SurveyedBag:
    """A bag with what groups it."""

    path: Path
    rig: str
    named_by: NamedBy
    start_ns: int
    """Time of its first message [ns since the epoch]."""
    checksums: tuple[str, ...]
    """SHA-256 of the files that hold its messages."""
    custom_data: Mapping[str, str] = field(default_factory=dict)
    """What its recorder wrote about the trial, such as weights on the rods."""

    @property
    def name(self) -> str:
        """What people call it."""
        return bag_name(self.path)

    @property
    def start(self) -> datetime:
        """Time of its first message where this computer is."""
        return datetime.fromtimestamp(self.start_ns * 1e-9).astimezone()

    @property
    def day(self) -> str:
        """The day of its start."""
        return self.start.strftime("%Y-%m-%d")


@dataclass(frozen=True)
class LeftOut:
    """A bag that is not used."""

    bag: str
    reason: str


@dataclass(frozen=True)
class Piece:
    """Bags of one rig that are identified together."""

    rig: str
    name: str
    """The day, or the bag's name."""
    bags: tuple[SurveyedBag, ...]
    """In the order of their start."""

    @property
    def start(self) -> str:
        """Time of its first message."""
        return self.bags[0].start.isoformat(timespec="milliseconds")

    @property
    def folder(self) -> str:
        """Name of the folder for what comes of it; no two pieces of a survey have the same."""
        readable = re.sub(r"[^A-Za-z0-9.-]+", "_", f"{self.rig} {self.name}").strip("_.")[:_LONGEST_NAME]
        is_bag = len(self.bags) == 1 and self.name == self.bags[0].name
        return f"{readable}_{_digest([self.rig, self.name, str(self.bags[0].path) if is_bag else ''])[:8]}"

    def key(self, configuration: Mapping[str, Any]) -> str:
        """Return what all that its result depends on is known by: bags, configuration, and the package's version."""
        bags = [(bag.checksums, sorted(bag.custom_data.items())) for bag in self.bags]
        return _digest([bags, sorted(configuration.items()), versions()["cdp_ident"]])


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()


def surveyed(bags: Sequence[Path], topic: str) -> tuple[list[SurveyedBag], list[LeftOut]]:
    """Return bags with what groups them, and those that cannot be read or are copies of others.

    A bag whose recorder wrote no name of the rig is of the rig of the other bags in its folder, if they are of one,
    else of one that is named as the folder. `topic` is read where there are no metadata that tell the time.
    """
    said = {bag: Metadata.of(bag) for bag in bags}
    found, left_out, owner = [], [], dict[str, Path]()
    for bag, metadata in said.items():
        neighbours = {other.rig for path, other in said.items() if path.parent == bag.parent and other.rig}
        named_by: NamedBy = "recorder" if metadata.rig else "neighbours" if len(neighbours) == 1 else "folder"
        name = metadata.rig or (neighbours.pop() if len(neighbours) == 1 else shown(bag.resolve().parent.name))
        try:
            checksums = tuple(bag_checksums(bag).values())
            start = metadata.start_ns
            if start is None:
                start = next((stamp for stamp in read_joint_states(bag, topic).stamps.tolist() if stamp), 0)
        except BagError as error:
            left_out.append(LeftOut(str(bag), shown(error)))
            continue
        copied = next((owner[checksum] for checksum in checksums if checksum in owner), None)
        if copied:
            left_out.append(LeftOut(str(bag), f"it is the same bag as {copied}"))
            continue
        owner |= dict.fromkeys(checksums, bag)
        found.append(SurveyedBag(bag.resolve(), name, named_by, start, checksums, metadata.custom_data))
    return found, left_out


def pieces_of(bags: Sequence[SurveyedBag], by: By) -> Iterator[Piece]:
    """Yield the pieces, by rig and in the order of time."""

    def belongs(bag: SurveyedBag) -> tuple[str, str]:
        return bag.rig, bag.day if by == "day" else str(bag.path)

    in_order = sorted(bags, key=lambda bag: (bag.rig, bag.start_ns, bag.path))
    for (rig, _), together in groupby(in_order, belongs):
        members = tuple(together)
        yield Piece(rig, members[0].day if by == "day" else members[0].name, members)


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


@dataclass(frozen=True)
class Plan:
    """What there is to do."""

    tasks: tuple[Task, ...]
    """By rig and in the order of time."""
    done: Mapping[Path, Finished]
    """What is kept of an earlier survey, by the folders of the tasks."""
    left_out: tuple[LeftOut, ...]
    """Bags that are of no piece."""

    @property
    def left(self) -> list[Task]:
        """What is still to be done."""
        return [task for task in self.tasks if task.folder not in self.done]


def plan(folders: Sequence[Path], out: Path, by: By, given: Mapping[str, Any], anew: bool = False) -> Plan:
    """Find the bags in folders and below them, and what is still to be done for a survey in the folder `out`.

    `given` is the configuration of `identify`, by name; `anew` says whether nothing is kept of an earlier survey.

    Raises:
        OptionError: the configuration is not usable, or has a weight of a bag that is not there.
        BagError: a folder holds no bag, or no bag can be read.
    """
    settings = Settings.of(given)
    bags, left_out = surveyed(bags_below(folders), settings.trial.topic)
    if not bags:
        raise BagError(f"no bag can be read: {left_out[0].bag}: {left_out[0].reason}")
    refuse_unknown(settings.weights, {bag.name for bag in bags}, "bag of a weight (trials.<bag>.added)")
    tasks = tuple(_task(piece, out.resolve() / PIECES, given) for piece in pieces_of(bags, by))
    kept = {} if anew else {task.folder: found for task in tasks if (found := finished(task))}
    return Plan(tasks, kept, tuple(left_out))


def _task(piece: Piece, place: Path, given: Mapping[str, Any]) -> Task:
    given = given_for(given, {bag.name for bag in piece.bags})
    return Task(piece, place / piece.folder, given, piece.key(Settings.of(given).values()))


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


def conduct(planned: Plan, executor: Executor) -> Iterator[Finished]:
    """Yield the result of each remaining piece when it is finished; it is on the disk then."""
    for task, problem in each(
        executor, identify_piece, planned.left, lambda task, why: (task, f"it failed twice: {why}")
    ):
        elsewhere = f"its report is not in {task.folder}: the machines of a cluster need the folders at the same paths"
        yield finished(task) or Finished(task.piece, task.folder, None, problem=problem or elsewhere)


def identify_piece(task: Task) -> tuple[Task, str]:
    """Identify a piece into its folder, in whatever process; return its task, and why there is no result, if so."""
    try:
        _identify(task)
    except CdpIdentError as error:
        return task, shown(error, _LONGEST_PROBLEM)
    except Exception as error:  # noqa: BLE001 - whatever it is, the other pieces go on
        return task, shown(f"{type(error).__name__}: {error}", _LONGEST_PROBLEM)
    return task, ""


def _identify(task: Task) -> None:
    try:
        (task.folder / RECORD).unlink(missing_ok=True)  # the piece is not finished while its report is replaced
    except OSError as error:
        raise OptionError(f"{task.folder} cannot be written: {error.strerror or error}") from error
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
    bags = [asdict(bag) for bag in left_out]
    record = {"schema": _SCHEMA, "key": task.key, "failure": result.failure, "left_out": bags}
    write_files(task.folder, {RECORD: json_text(record)})


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
