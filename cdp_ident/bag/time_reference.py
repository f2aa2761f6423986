# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`sensor_msgs/msg/TimeReference` from its bytes on the wire (CDR), without ROS."""

import struct

from cdp_ident.bag.joint_state import LITTLE_ENDIAN, NANOSECONDS, cdr_text

MESSAGE_TYPE = "sensor_msgs/msg/TimeReference"

_HEAD = struct.Struct("<4siI8siI")
_NO_FRAME = cdr_text("")


def serialize_time_reference(stamp_ns: int, device_ns: int, source: str) -> bytes:
    """Return the CDR bytes of a TimeReference of stamp and device's time [ns]."""
    stamp, device = divmod(stamp_ns, NANOSECONDS), divmod(device_ns, NANOSECONDS)
    return _HEAD.pack(LITTLE_ENDIAN, *stamp, _NO_FRAME, *device) + cdr_text(source)


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
