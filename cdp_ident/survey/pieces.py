# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a survey is made of: bags grouped by rig, and pieces of a rig's bags that are identified together."""

import hashlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

from cdp_ident.bag.metadata import origin_of, read_custom_data
from cdp_ident.bag.reader import bag_name, read_joint_states
from cdp_ident.errors import BagError
from cdp_ident.outside_text import shown
from cdp_ident.report.provenance import bag_checksums, versions

By = Literal["day", "bag"]
NamedBy = Literal["recorder", "neighbours", "folder"]
"""Who says of which rig a bag is: its recorder, the recorder of the others in its folder, or the folder's name."""

_LONGEST_NAME = 60


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
    def day(self) -> str:
        """The day of its start where this computer is."""
        return datetime.fromtimestamp(self.start_ns * 1e-9).astimezone().strftime("%Y-%m-%d")


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
    def start_ns(self) -> int:
        """Time of its first message [ns since the epoch]."""
        return self.bags[0].start_ns

    @property
    def folder(self) -> str:
        """Name of the folder for what comes of it; no two pieces of a survey have the same."""
        readable = re.sub(r"[^A-Za-z0-9.-]+", "_", f"{self.rig} {self.name}").strip("_.")[:_LONGEST_NAME]
        return f"{readable}_{_digest([self.rig, self.name, str(self.bags[0].path) if self._is_bag else ''])[:8]}"

    @property
    def _is_bag(self) -> bool:
        return len(self.bags) == 1 and self.name == self.bags[0].name

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
    origins = {bag: origin_of(bag) for bag in bags}
    found, left_out, owner = [], [], dict[str, Path]()
    for bag, origin in origins.items():
        neighbours = {other.rig for path, other in origins.items() if path.parent == bag.parent and other.rig}
        named_by: NamedBy = "recorder" if origin.rig else "neighbours" if len(neighbours) == 1 else "folder"
        name = origin.rig or (neighbours.pop() if len(neighbours) == 1 else shown(bag.resolve().parent.name))
        try:
            checksums = tuple(bag_checksums(bag).values())
            start = _first_stamp(bag, topic) if origin.start_ns is None else origin.start_ns
        except BagError as error:
            left_out.append(LeftOut(str(bag), shown(error)))
            continue
        copied = next((owner[checksum] for checksum in checksums if checksum in owner), None)
        if copied:
            left_out.append(LeftOut(str(bag), f"it is the same bag as {copied}"))
            continue
        owner |= dict.fromkeys(checksums, bag)
        custom_data, _ = read_custom_data(bag)
        found.append(SurveyedBag(bag.resolve(), name, named_by, start, checksums, custom_data))
    return found, left_out


def _first_stamp(bag: Path, topic: str) -> int:
    return next((stamp for stamp in read_joint_states(bag, topic).stamps.tolist() if stamp), 0)


def pieces_of(bags: Sequence[SurveyedBag], by: By) -> Iterator[Piece]:
    """Yield the pieces, by rig and in the order of time."""

    def belongs(bag: SurveyedBag) -> tuple[str, str]:
        return bag.rig, bag.day if by == "day" else str(bag.path)

    in_order = sorted(bags, key=lambda bag: (bag.rig, bag.start_ns, bag.path))
    for (rig, _), together in groupby(in_order, belongs):
        members = tuple(together)
        yield Piece(rig, members[0].day if by == "day" else members[0].name, members)
