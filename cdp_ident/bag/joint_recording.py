# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The joint positions of a bag as arrays, and the device's own times of them, collected message by message."""

from __future__ import annotations

import struct
from array import array
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from cdp_ident.arrays import Array, Mask, Rows, Times
from cdp_ident.bag.device_messages import DIAGNOSTICS, TIME_REFERENCE, ClockRate, parse_time_reference, read_statuses
from cdp_ident.bag.joint_state import HEAD_OFFSET, NANOSECONDS, STAMP_OFFSET, Layout, parse_layout
from cdp_ident.bag.limits import plain_message
from cdp_ident.errors import BagError
from cdp_ident.outside_text import shown

_LAYOUTS_AT_HAND = 8
_MOST_JOINTS = 256
_LONGEST_HEAD = 1 << 14
"""Bytes of the frame and joint names of a message; 256 joints with names of 60 letters have no more."""
_MOST_ROWS = 8_000_000
"""Two hours at 1 kHz."""
_MOST_VALUES = 1 << 25
"""Positions of all joints in all rows: an hour of a robot with eight joints at 1 kHz."""
_MOST_REASONS, _REASONS_SHOWN = 100, 3
_MOST_LAYOUTS = 1 << 14
"""Ways in which messages begin; writers have one or a few."""
_LEAST_SHARE = 0.9
"""A device's time that fewer of the samples have is not used."""


@dataclass(frozen=True)
class JointRecording(Rows):
    """The joint positions that a bag holds on one topic, in the order in which they are stored."""

    name: str
    """What people call the bag."""
    topic: str
    joints: tuple[str, ...]
    """Every joint that is named in any message."""
    stamps: Times
    """(n,) of the messages' headers [ns since the epoch]; 0 where a message has none, or one that is no time."""
    positions: Array
    """(n, joints) positions as recorded [rad or m]; NaN where a message does not name the joint."""
    notes: tuple[str, ...]
    """What was dropped or noticed while reading, in words, with numbers."""
    device: Times | None = None
    """(n,) the device's own time [ns], where the bag has it; it begins anew where the device was reset."""
    device_rate: ClockRate | None = None
    """How fast its clock runs, as its driver says last."""
    efforts: Array | None = None
    """(n, joints) efforts as recorded [N m or N], NaN where a message has none; None where no message has any."""
    receipts: Times | None = None
    """(n,) times of receipt [ns since the epoch]; None where nothing was received."""


@dataclass
class _Alike:
    """Messages of one layout: their rows in the recording, stamps and positions."""

    layout: Layout
    rows: array[int] = field(default_factory=lambda: array("q"))
    stamps: array[int] = field(default_factory=lambda: array("q"))
    positions: bytearray = field(default_factory=bytearray)
    """As they are in the messages."""
    efforts: bytearray = field(default_factory=bytearray)
    """As they are in the messages, of those that have any, whose rows follow."""
    with_efforts: array[int] = field(default_factory=lambda: array("q"))

    def take(self, row: int, raw: bytes) -> bool:
        """Add a message if it has this layout, and say whether it had."""
        layout = self.layout
        fits = raw.startswith(layout.head, HEAD_OFFSET) and raw[:2] == layout.byte_order
        end = layout.offset + layout.positions.size
        if not fits or len(raw) < end:
            return False
        seconds, nanoseconds = layout.stamp.unpack_from(raw, STAMP_OFFSET)
        self.positions += raw[layout.offset : end]
        if efforts := layout.efforts(raw):
            self.efforts += efforts
            self.with_efforts.append(row)
        is_time = seconds >= 0 and nanoseconds < NANOSECONDS
        self.stamps.append(seconds * NANOSECONDS + nanoseconds if is_time else 0)
        self.rows.append(row)
        return True

    def numbers(self, raw: bytearray) -> Array:
        """Return numbers as they are in the messages as (rows, joints)."""
        return np.frombuffer(raw, f"{self.layout.positions.format[0]}f8").reshape(-1, len(self.layout.names))


class JointStates:
    """Collects messages into arrays; a layout is found once and then serves all messages that begin alike."""

    def __init__(self, bag: Path) -> None:
        self._bag = bag
        self._receipts = array("q")
        self._groups: list[_Alike] = []
        self._at_hand: list[_Alike] = []
        self._joints: dict[str, None] = {}
        """Names of all joints, in the order in which they came."""
        self._dropped = Counter[str]()
        """Messages that are not used, by the reason."""

    def __len__(self) -> int:
        """Return how many messages were added."""
        return len(self._receipts)

    def drop(self, reason: str) -> None:
        """Count a message that is not used."""
        self._dropped[reason if len(self._dropped) < _MOST_REASONS else "others"] += 1

    @property
    def dropped(self) -> str:
        """How many messages are not used, and why, in words; empty if all are."""
        reasons = [f"{count} {shown(reason)}" for reason, count in self._dropped.most_common(_REASONS_SHOWN)]
        return f"{sum(self._dropped.values())} messages are dropped: {', '.join(reasons)}" if reasons else ""

    def add(self, receipt: int, raw: bytes) -> None:
        """Add one message: its time of receipt [ns since the epoch] and its bytes."""
        row = len(self._receipts)
        try:
            raw = plain_message(raw)
            if not any(group.take(row, raw) for group in self._at_hand):
                self._begin_group(raw).take(row, raw)
        except struct.error:
            self.drop("are cut short")
        except ValueError as error:
            self.drop(str(error))
        else:
            self._receipts.append(receipt)
            if row >= _MOST_ROWS or row * len(self._joints) > _MOST_VALUES:
                raise BagError(f"{self._bag} holds too many joint states ({row}): cut the swing out of it")

    def _begin_group(self, raw: bytes) -> _Alike:
        layout = parse_layout(raw)
        if len(layout.head) > _LONGEST_HEAD or len(layout.names) > _MOST_JOINTS:
            raise ValueError("have more names than are believed")
        if not any(layout.names):
            raise ValueError("name no joint")
        if len(set(layout.names)) < len(layout.names):
            raise ValueError("name a joint twice")
        group = _Alike(layout)
        self._groups.append(group)
        self._at_hand = [group, *self._at_hand[: _LAYOUTS_AT_HAND - 1]]
        self._joints |= dict.fromkeys(layout.names)
        if len(self._joints) > _MOST_JOINTS or len(self._groups) > _MOST_LAYOUTS:
            raise BagError(
                f"{self._bag} names {len(self._joints)} joints in {len(self._groups)} ways: at most {_MOST_JOINTS} and "
                f"{_MOST_LAYOUTS} are believed"
            )
        return group

    def recording(self, name: str, topic: str, notes: list[str]) -> JointRecording:
        """Return all messages as one recording, in the order in which they are stored."""
        joints = tuple(self._joints)
        column = {joint: i for i, joint in enumerate(joints)}
        positions = np.full((len(self._receipts), len(joints)), np.nan)
        efforts = np.full_like(positions, np.nan) if any(group.efforts for group in self._groups) else None
        stamps = np.zeros(len(self._receipts), dtype=np.int64)
        receipts = np.array(self._receipts, dtype=np.int64)
        for group in self._groups:
            columns = [column[joint] for joint in group.layout.names]
            stamps[group.rows] = group.stamps
            positions[np.ix_(group.rows, columns)] = group.numbers(group.positions)
            if efforts is not None:
                efforts[np.ix_(group.with_efforts, columns)] = group.numbers(group.efforts)
        if self.dropped:
            notes = [*notes, f"of {topic} {self.dropped}"]
        return JointRecording(name, topic, joints, stamps, positions, tuple(notes), efforts=efforts, receipts=receipts)


@dataclass
class _TimeReferences:
    """The time references of one topic."""

    source: str = ""
    stamps: array[int] = field(default_factory=lambda: array("q"))
    times: array[int] = field(default_factory=lambda: array("q"))

    def at(self, stamps: Times) -> tuple[Times, Mask]:
        """Return the device's times of samples with these stamps (n,), and which of them are known."""
        known, first = np.unique(np.array(self.stamps, dtype=np.int64), return_index=True)
        place = np.minimum(np.searchsorted(known, stamps), len(known) - 1)
        return np.array(self.times, dtype=np.int64)[first][place], known[place] == stamps


class DeviceMessages:
    """Collects a bag's time references and statuses."""

    TYPES: ClassVar = (TIME_REFERENCE, DIAGNOSTICS)

    def __init__(self) -> None:
        self._topics: dict[str, _TimeReferences] = {}
        self._rates: dict[str, ClockRate] = {}

    def add(self, topic: str, message_type: str, raw: bytes) -> None:
        """Add a message of one of TYPES; one that is not well-formed is passed over."""
        with suppress(ValueError, struct.error):
            raw = plain_message(raw)
            if message_type == DIAGNOSTICS:
                statuses = read_statuses(raw)
                self._rates |= {status.hardware_id: rate for status in statuses if (rate := status.clock_rate)}
                return
            stamp, device, source = parse_time_reference(raw)
            references = self._topics.setdefault(topic, _TimeReferences())
            references.source = source
            references.stamps.append(stamp)
            references.times.append(device)

    def added_to(self, recording: JointRecording) -> JointRecording:
        """Return a recording with the device's time of its samples, by whichever topic has nine in ten of their stamps.

        The few samples that lack it are dropped, and counted in a note.
        """
        for references in self._topics.values() if len(recording.stamps) else ():
            times, known = references.at(recording.stamps)
            if np.mean(known) >= _LEAST_SHARE:
                lacking = np.count_nonzero(~known)
                notes = [f"{lacking} samples without the device's own time are dropped"] if lacking else []
                rate = self._rates.get(references.source)
                return replace(
                    recording[known], notes=(*recording.notes, *notes), device=times[known], device_rate=rate
                )
        return recording
