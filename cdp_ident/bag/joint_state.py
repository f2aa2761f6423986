"""`sensor_msgs/msg/JointState` to and from its bytes on the wire (CDR), without ROS."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

MESSAGE_TYPE = "sensor_msgs/msg/JointState"
NANOSECONDS = 1_000_000_000
"""In a second."""


@cache
def typestore() -> "Typestore":
    """Return the message definitions of the ROS distribution that the package is for.

    To load them takes as long as all else of a driver, which reads and writes no bag.
    """
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    return get_typestore(Stores.ROS2_JAZZY)


def serialize_joint_state(
    names: Sequence[str], positions: Sequence[float], stamp_ns: int, efforts: npt.ArrayLike = ()
) -> bytes:
    """Return the CDR bytes of a JointState.

    `positions` are in rad for revolute joints and m for prismatic ones, one for each of `names`; `stamp_ns` is the
    time of the measurement [ns since the epoch]; `efforts` are those of motors, where there are any [N m]. Velocity
    stays empty: encoders do not measure it.
    """
    if len(names) != len(positions):
        raise ValueError(f"{len(names)} names but {len(positions)} positions")
    types = typestore().types
    seconds, nanoseconds = divmod(stamp_ns, NANOSECONDS)
    stamp = types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    empty = np.empty(0)
    message = types[MESSAGE_TYPE](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id=""),
        name=list(names),
        position=np.asarray(positions, dtype=np.float64),
        velocity=empty,
        effort=np.asarray(efforts, dtype=np.float64),
    )
    return bytes(typestore().serialize_cdr(message, MESSAGE_TYPE))


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


STAMP_OFFSET = 4
HEAD_OFFSET = 12


def parse_layout(raw: bytes) -> Layout:
    """Find the names and positions in the CDR bytes of a JointState.

    What stands behind the positions need not be well-formed: some writers leave stray bytes there, which readers of
    whole messages refuse. Raises ValueError, struct.error or UnicodeDecodeError (a ValueError) where the bytes are no
    JointState.
    """
    if raw[:2] not in (b"\0\0", b"\0\1"):
        raise ValueError("not plain CDR")
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
            raise ValueError("a text is longer than the message")
        position += length
        return value.removesuffix(b"\0").decode()

    text()
    names = number()
    if names > len(raw):
        raise ValueError("more names than bytes")
    name = tuple(text() for _ in range(names))
    positions = number()
    if positions != names:
        raise ValueError(f"{names} names but {positions} positions")
    # Eight-byte numbers are aligned from the end of the four bytes of the encapsulation header.
    offset = position + (-(position - 4) % 8 if positions else 0)
    if offset + 8 * positions > len(raw):
        raise ValueError("more positions than bytes")
    return Layout(
        names=name,
        positions=struct.Struct(f"{order}{positions}d"),
        offset=offset,
        head=raw[HEAD_OFFSET:position],
        stamp=struct.Struct(f"{order}iI"),
        byte_order=raw[:2],
    )
