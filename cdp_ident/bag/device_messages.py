# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What drivers say of their devices, in bytes on the wire (CDR) and without ROS: TimeReference, DiagnosticArray."""

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

from cdp_ident.bag.joint_state import LITTLE_ENDIAN, NANOSECONDS, cdr_text, typestore

TIME_REFERENCE = "sensor_msgs/msg/TimeReference"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
CLOCK_RATE, CLOCK_RATE_STD = "clock rate [ppm]", "clock rate std [ppm]"
"""Keys of the rate of a device's clock (by how much it is fast) and of its standard deviation."""

_TIME_REFERENCE = struct.Struct("<4siI8siI")
_NO_FRAME = cdr_text("")


def serialize_time_reference(stamp_ns: int, device_ns: int, source: str) -> bytes:
    """Return the CDR bytes of a TimeReference of stamp and device's time [ns]."""
    stamp, device = divmod(stamp_ns, NANOSECONDS), divmod(device_ns, NANOSECONDS)
    return _TIME_REFERENCE.pack(LITTLE_ENDIAN, *stamp, _NO_FRAME, *device) + cdr_text(source)


def parse_time_reference(raw: bytes) -> tuple[int, int, str]:
    """Return stamp [ns], device's time [ns] and source in the CDR bytes of a TimeReference.

    Raises ValueError or struct.error where the bytes are none.
    """
    if raw[:2] not in (b"\0\0", b"\0\1"):
        raise ValueError("not plain CDR")
    order = "<" if raw[1] else ">"
    seconds, nanoseconds, frame = struct.unpack_from(f"{order}iII", raw, 4)
    # Four-byte numbers are aligned from the end of the encapsulation header, which has four bytes itself.
    at = 16 + frame + -frame % 4
    device_seconds, device_nanoseconds, length = struct.unpack_from(f"{order}iII", raw, at)
    source = raw[at + 12 : at + 12 + length]
    if len(source) != length or max(nanoseconds, device_nanoseconds) >= NANOSECONDS:
        raise ValueError("not a time reference")
    stamp, device = seconds * NANOSECONDS + nanoseconds, device_seconds * NANOSECONDS + device_nanoseconds
    return stamp, device, source.removesuffix(b"\0").decode(errors="replace")


class ClockRate(NamedTuple):
    """How fast a device's clock runs against ROS time."""

    fast: float
    """By how much it is fast, relative: 1e-6 is one microsecond in a second."""
    std: float
    """Standard deviation of that."""

    def __str__(self) -> str:
        return f"{1e6 * self.fast:.3g} ± {1e6 * self.std:.2g} ppm"


class Level(IntEnum):
    """Levels of a diagnostic status, as REP 107 has them."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Health:
    """How a device or a node is doing: one status of a DiagnosticArray."""

    level: int
    """A `Level`."""
    message: str
    values: Mapping[str, str]
    hardware_id: str = ""
    """Which device it is about, if any."""
    name: str = ""
    """Who says it, where that is not the node that has it."""

    @property
    def clock_rate(self) -> ClockRate | None:
        """How fast the device's clock runs, where the driver reported it."""
        try:
            fast, std = (float(self.values[key]) * 1e-6 for key in (CLOCK_RATE, CLOCK_RATE_STD))
        except (KeyError, ValueError):
            return None
        return ClockRate(fast, std) if abs(fast) < 0.5 and 0.0 <= std < math.inf else None


def read_statuses(raw: bytes) -> list[Health]:
    """Return what is said in the bytes of a DiagnosticArray; nothing where they are none."""
    try:
        message: Any = typestore().deserialize_cdr(raw, DIAGNOSTICS)
    except Exception:  # noqa: BLE001  a foreign message: rosbags raises whatever its bytes lead to
        return []
    return [
        Health(of.level, of.message, {value.key: value.value for value in of.values}, of.hardware_id, of.name)
        for of in message.status
    ]
