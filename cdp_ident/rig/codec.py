"""What the two ways of writing records as bytes have in common."""

import re
from binascii import crc_hqx
from typing import Protocol

from cdp_ident.rig.records import CartCommand, Hello, Record, Sample

UNSIGNED_32 = 0xFFFFFFFF
_FIRMWARE = re.compile(r"[ -)+\-./0-~]{0,32}")


class FrameError(Exception):
    """A frame's bytes are not a record; never leaves this package's rig part."""


class ChecksumError(FrameError):
    """A frame has the right form, but its checksum does not match."""


class Codec(Protocol):
    """Turns records into frames and back. A frame ends with the delimiter, which occurs nowhere else in it."""

    name: str
    delimiter: bytes
    """The byte that ends a frame."""

    def encode(self, record: Record) -> bytes:
        """Return the frame of a record, its delimiter included."""

    def decode(self, frame: bytes) -> Record:
        """Return the record of a frame given without its delimiter. Raises `FrameError` where it is none."""


def checksum(data: bytes) -> int:
    """Return the CRC-16 of both codecs: polynomial 0x1021, start 0xFFFF, not reflected (CRC-16/IBM-3740).

    Its value for b"123456789" is 0x29B1.
    """
    return crc_hqx(data, 0xFFFF)


def is_valid(record: Record) -> bool:
    """Tell whether every field is in the range that the protocol gives it."""
    if isinstance(record, Sample):
        unsigned = _are_unsigned(record.sequence, record.time_us)
        return unsigned and _are_signed(record.cart, record.inner, record.outer) and 0 <= record.status <= 0xFF
    if isinstance(record, CartCommand):
        return _are_unsigned(record.sequence) and _are_signed(record.acceleration)
    return all(0 < value <= UNSIGNED_32 for value in record[:3]) and _FIRMWARE.fullmatch(record.firmware) is not None


def _are_unsigned(*values: int) -> bool:
    return all(0 <= value <= UNSIGNED_32 for value in values)


def _are_signed(*values: int) -> bool:
    return all(-(2**31) <= value < 2**31 for value in values)


def hello_or_error(period_us: int, inner_counts: int, outer_counts: int, firmware: bytes) -> Hello:
    """Return a greeting from its decoded fields. Raises `FrameError` where a field is out of its range."""
    hello = Hello(period_us, inner_counts, outer_counts, firmware.decode("ascii", "replace"))
    if not is_valid(hello):
        raise FrameError("a greeting with a field out of range")
    return hello
