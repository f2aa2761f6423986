# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a bag holds of the device beside its samples: its own time of each, and how fast its clock runs."""

import struct
from array import array
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from cdp_ident.arrays import Mask, Times
from cdp_ident.bag import diagnostics, time_reference
from cdp_ident.bag.diagnostics import ClockRate, read_statuses
from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.bag.limits import plain_message
from cdp_ident.bag.time_reference import parse_time_reference

_LEAST_SHARE = 0.9
"""A device's time that fewer of the samples have is not used."""


@dataclass
class _Topic:
    """The time references of one topic."""

    source: str = ""
    stamps: "array[int]" = field(default_factory=lambda: array("q"))
    times: "array[int]" = field(default_factory=lambda: array("q"))

    def at(self, stamps: Times) -> tuple[Times, Mask]:
        """Return the device's times of samples with these stamps (n,), and which of them are known."""
        known, first = np.unique(np.array(self.stamps, dtype=np.int64), return_index=True)
        place = np.minimum(np.searchsorted(known, stamps), len(known) - 1)
        return np.array(self.times, dtype=np.int64)[first][place], known[place] == stamps


class DeviceMessages:
    """Collects a bag's time references and statuses."""

    TYPES: ClassVar = (time_reference.MESSAGE_TYPE, diagnostics.MESSAGE_TYPE)

    def __init__(self) -> None:
        self._topics: dict[str, _Topic] = {}
        self._rates: dict[str, ClockRate] = {}

    def add(self, topic: str, message_type: str, raw: bytes) -> None:
        """Add a message of one of TYPES; one that is not well-formed is passed over."""
        try:
            raw = plain_message(raw)
            if message_type == time_reference.MESSAGE_TYPE:
                stamp, device, source = parse_time_reference(raw)
                references = self._topics.setdefault(topic, _Topic())
                references.source = source
                references.stamps.append(stamp)
                references.times.append(device)
                return
        except (ValueError, struct.error):
            return
        self._rates |= {status.hardware_id: rate for status in read_statuses(raw) if (rate := status.clock_rate)}

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
