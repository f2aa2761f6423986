# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What drivers say of their rigs, in the bytes of `diagnostic_msgs/msg/DiagnosticArray` messages, without ROS."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from cdp_ident.bag.joint_state import typestore

MESSAGE_TYPE = "diagnostic_msgs/msg/DiagnosticArray"
CLOCK_RATE, CLOCK_RATE_STD = "clock rate [ppm]", "clock rate std [ppm]"
"""Keys of the rate of a device's clock (by how much it is fast) and of its standard deviation."""


class ClockRate(NamedTuple):
    """How fast a device's clock runs against ROS time."""

    fast: float
    """By how much it is fast, relative: 1e-6 is one microsecond in a second."""
    std: float
    """Standard deviation of that."""

    def __str__(self) -> str:
        return f"{1e6 * self.fast:.3g} ± {1e6 * self.std:.2g} ppm"


@dataclass(frozen=True)
class DeviceStatus:
    """One status of a DiagnosticArray."""

    name: str
    """Who says it."""
    hardware_id: str
    """Of which device."""
    message: str
    values: Mapping[str, str]

    @property
    def clock_rate(self) -> ClockRate | None:
        """How fast the device's clock runs, where the driver reported it."""
        try:
            fast, std = (float(self.values[key]) * 1e-6 for key in (CLOCK_RATE, CLOCK_RATE_STD))
        except (KeyError, ValueError):
            return None
        return ClockRate(fast, std) if abs(fast) < 0.5 and 0.0 <= std < math.inf else None


def read_statuses(raw: bytes) -> list[DeviceStatus]:
    """Return what is said in the bytes of a DiagnosticArray; nothing where they are none."""
    try:
        message: Any = typestore().deserialize_cdr(raw, MESSAGE_TYPE)
    except Exception:  # noqa: BLE001  a foreign message: rosbags raises whatever its bytes lead to
        return []
    return [
        DeviceStatus(
            status.name, status.hardware_id, status.message, {value.key: value.value for value in status.values}
        )
        for status in message.status
    ]
