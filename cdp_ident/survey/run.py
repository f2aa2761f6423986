# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A survey from folders to finished pieces: what is there already is kept, the rest goes to the workers."""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cdp_ident.bag.folders import bags_below
from cdp_ident.configuration.settings import Settings, given_for
from cdp_ident.errors import BagError
from cdp_ident.survey.identification import Finished, Task, finished, identify_piece
from cdp_ident.survey.pieces import By, LeftOut, Piece, pieces_of, surveyed
from cdp_ident.survey.workers import each
from cdp_ident.user_input import refuse_unknown

PIECES = "pieces"
"""The folder with a folder for each piece."""


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
    """Find the bags and what is still to be done.

    Args:
        folders: bags are looked for in them and below.
        out: the survey's folder.
        by: what a piece is.
        given: the configuration of `identify`, by name.
        anew: whether nothing is kept of an earlier survey.

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


def conduct(planned: Plan, executor: Executor) -> Iterator[Finished]:
    """Yield the result of each remaining piece when it is finished; it is on the disk then."""
    tasks = {task.folder: task for task in planned.left}
    for folder, problem in each(executor, identify_piece, planned.left, _failed):
        task = tasks[folder]
        yield finished(task) or Finished(task.piece, folder, None, problem=problem or _not_here(task))


def _failed(task: Task, reason: str) -> tuple[Path, str]:
    return task.folder, f"it failed twice: {reason}"


def _not_here(task: Task) -> str:
    return f"its report is not in {task.folder}: the machines of a cluster need the folders at the same paths"
