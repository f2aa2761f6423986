# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`sensor_msgs/msg/JointState` to and from its bytes on the wire (CDR), without ROS."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

MESSAGE_TYPE = "sensor_msgs/msg/JointState"
NANOSECONDS = 1_000_000_000
"""In a second."""
LITTLE_ENDIAN = b"\0\1\0\0"
"""What plain CDR begins with."""
STAMP_OFFSET, HEAD_OFFSET = 4, 12


@cache
def typestore() -> "Typestore":
    """Return the message definitions of the ROS distribution that the package is for.

    To load them takes as long as all else of a driver, which needs none.
    """
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    return get_typestore(Stores.ROS2_JAZZY)


def serialize_joint_state(
    names: Sequence[str],
    positions: Sequence[float],
    stamp_ns: int,
    velocities: Sequence[float] = (),
    efforts: Sequence[float] = (),
) -> bytes:
    """Return the CDR bytes of a JointState.

    `positions` are in rad for revolute joints and m for prismatic ones, one for each of `names`; so are `velocities`
    [rad/s, m/s] and `efforts` of motors [N m, N], if there are any; `stamp_ns` is the time of the measurement [ns since
    the epoch].
    """
    sizes = len(positions), len(velocities), len(efforts)
    message, head = _written(tuple(names), *sizes)
    values = (*positions, sizes[1], *velocities, sizes[2], *efforts)
    return message.pack(LITTLE_ENDIAN, *divmod(stamp_ns, NANOSECONDS), head, *values)


@cache
def _written(names: tuple[str, ...], positions: int, velocities: int, efforts: int) -> tuple[struct.Struct, bytes]:
    """Return how a JointState of these joints is written, and what stands between its stamp and its positions."""
    if len(names) != positions or not {velocities, efforts} <= {0, positions}:
        others = f"{velocities} velocities and {efforts} efforts"
        raise ValueError(f"{len(names)} names but {positions} positions, {others}")
    count = struct.pack("<I", positions)
    head = cdr_text("") + count + b"".join(map(cdr_text, names)) + count
    # Eight-byte numbers are aligned from the end of the four bytes of the encapsulation header.
    padded = head + bytes(-(HEAD_OFFSET - 4 + len(head)) % 8 if names else 0)
    of_velocities = f"4x{positions}d" if velocities else ""
    of_efforts = f"{'4x' * bool(velocities)}{positions}d" if efforts else ""
    return struct.Struct(f"<4siI{len(padded)}s{positions}dI{of_velocities}I{of_efforts}"), padded


@lru_cache(maxsize=64)
def cdr_text(text: str) -> bytes:
    """Return a text in CDR, with zeros up to where the next number may begin."""
    data = text.encode() + b"\0"
    return struct.pack("<I", len(data)) + data + bytes(-len(data) % 4)


@dataclass(frozen=True)
class Layout:
    """Where in the bytes of a JointState its positions are; the same for all messages that begin alike."""

    names: tuple[str, ...]
    positions: struct.Struct
    """Reads all positions from `offset` on."""
    offset: int
    head: bytes
    """What stands between the stamp and the positions: frame, names and the number of positions."""
    stamp: struct.Struct
    """Reads seconds and nanoseconds from `STAMP_OFFSET` on."""
    byte_order: bytes

    def efforts(self, raw: bytes) -> bytes:
        """Return the bytes of a message's efforts; empty unless there are as many as positions."""
        count = struct.Struct(f"{self.positions.format[0]}I")
        at = self.offset + self.positions.size
        for wanted in (False, True):
            if at + count.size > len(raw):
                return b""
            (values,) = count.unpack_from(raw, at)
            first = at + count.size + (-at % 8 if values else 0)
            at = first + 8 * values
            if wanted and values == len(self.names) and at <= len(raw):
                return raw[first:at]
        return b""


def parse_layout(raw: bytes) -> Layout:
    """Find the names and positions in the CDR bytes of a JointState.

    What stands behind the positions need not be well-formed: some writers leave stray bytes there, which readers of
    whole messages refuse. Raises ValueError, which says what such messages have, or struct.error where the bytes are no
    JointState.
    """
    if raw[:2] not in (b"\0\0", b"\0\1"):
        is_newer = raw[:1] == b"\0" and raw[1:2] <= b"\x0b"
        raise ValueError(f"are {'XCDR2 or parameter lists' if is_newer else 'not ROS 2 messages'}: expected plain CDR")
    order = "<" if raw[1] else ">"
    count = struct.Struct(f"{order}I")
    position = HEAD_OFFSET

    def number() -> int:
        nonlocal position
        position += -position % 4
        (value,) = count.unpack_from(raw, position)
        position += 4
        return int(value)

    def text() -> str:
        nonlocal position
        length = number()
        value = raw[position : position + length]
        if len(value) != length:
            raise ValueError("have a text that is longer than the message")
        position += length
        try:
            return value.removesuffix(b"\0").decode()
        except UnicodeDecodeError as error:
            raise ValueError("have a text that is not UTF-8") from error

    text()
    names = number()
    if names > len(raw):
        raise ValueError("have more names than bytes")
    name = tuple(text() for _ in range(names))
    positions = number()
    if positions != names:
        raise ValueError(f"have {names} names but {positions} positions")
    # Eight-byte numbers are aligned from the end of the four bytes of the encapsulation header.
    offset = position + (-(position - 4) % 8 if positions else 0)
    if offset + 8 * positions > len(raw):
        raise ValueError("have more positions than bytes")
    return Layout(
        names=name,
        positions=struct.Struct(f"{order}{positions}d"),
        offset=offset,
        head=raw[HEAD_OFFSET:position],
        stamp=struct.Struct(f"{order}iI"),
        byte_order=raw[:2],
    )
