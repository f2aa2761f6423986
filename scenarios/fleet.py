# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags of several rigs on several days, as their recorders leave them."""

from collections.abc import Mapping
from pathlib import Path

from cdp_ident.report.schema import Section
from cdp_ident.survey.run import Finished, Piece, SurveyedBag
from reference.pendulum import TABLE_5
from scenarios.clean_bags import write_clean_bag

NOON = 1_717_156_800_000_000_000
"""31 May 2024, 12:00 UTC [ns since the epoch]."""
_DAY = 86_400_000_000_000


def write_fleet(folder: Path, days: Mapping[str, int], changes: Mapping[str, int], swing: float = 6.0) -> None:
    """Write a bag for each of so many days of each rig, let go a little differently each day.

    Args:
        folder: each rig's bags go into a folder below it.
        days: how many of them, by the rig's name.
        changes: the first day on which the outer joint's friction is half as large again, by the rig's name.
        swing: how long they swing freely [s].
    """
    for number, (rig, count) in enumerate(days.items()):
        for day in range(count):
            values = dict(TABLE_5)
            values["c2"] *= 1.5 if day >= changes.get(rig, count) else 1.0
            start = (2.2 - 0.05 * day - 0.03 * number, 2.0 + 0.07 * day)
            about = {"rig_name": f"/{rig}/driver"}
            write_clean_bag(folder / rig / f"trial_{day}", start, values, swing, NOON + day * _DAY, about)


def finished(report: Section | None, rig: str, day: int, problem: str = "") -> Finished:
    """Return what came of a day of a rig, whose report is given."""
    bag = SurveyedBag(Path(f"/trials/{rig}/{day}"), rig, "recorder", NOON + day * _DAY, (f"{rig}{day}",))
    piece = Piece(rig, f"day {day}", (bag,))
    return Finished(piece, Path("/survey/pieces") / piece.folder, report, problem=problem)
