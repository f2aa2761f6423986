# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Messages that a driver publishes beside joint states, as the bytes that a bag holds."""

from collections.abc import Mapping
from typing import Any

from cdp_ident.bag.device_messages import DIAGNOSTICS, TIME_REFERENCE
from cdp_ident.bag.joint_state import typestore


def diagnostics(statuses: Mapping[str, Mapping[str, str]], hardware_id: str = "") -> bytes:
    """Return a DiagnosticArray of statuses by name."""
    types = typestore().types
    status, value = types["diagnostic_msgs/msg/DiagnosticStatus"], types["diagnostic_msgs/msg/KeyValue"]
    message = types[DIAGNOSTICS](
        header=_header(0),
        status=[
            status(
                level=0,
                name=name,
                message="",
                hardware_id=hardware_id,
                values=[value(key=k, value=v) for k, v in values.items()],
            )
            for name, values in statuses.items()
        ],
    )
    return bytes(typestore().serialize_cdr(message, DIAGNOSTICS))


def time_reference(stamp_ns: int, device_ns: int, source: str = "device", frame: str = "") -> bytes:
    """Return a TimeReference."""
    message = typestore().types[TIME_REFERENCE](
        header=_header(stamp_ns, frame), time_ref=_time(device_ns), source=source
    )
    return bytes(typestore().serialize_cdr(message, TIME_REFERENCE))


def _header(stamp_ns: int, frame: str = "") -> Any:
    return typestore().types["std_msgs/msg/Header"](stamp=_time(stamp_ns), frame_id=frame)


def _time(nanoseconds: int) -> Any:
    sec, nanosec = divmod(nanoseconds, 1_000_000_000)
    return typestore().types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec)
