# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The serial protocol, as docs/reference/protocol.md describes it byte for byte: its records, and both codecs.

A rig sends samples of its encoders and now and then a greeting; it is sent commands of its cart.
"""

import math
import re
import struct
from abc import ABC, abstractmethod
from binascii import crc_hqx
from collections.abc import Sequence
from enum import IntFlag
from typing import ClassVar, NamedTuple

from cobs import cobs

UNSIGNED_32 = 0xFFFFFFFF
PROTOCOL_VERSION = 1
"""Version of the frames that this package speaks."""


class Status(IntFlag):
    """Bits of a sample's status flags; the others are reserved and sent as zero."""

    CART_FAULT = 1
    """The cart's encoder cannot be trusted (no signal, bad quadrature)."""
    INNER_FAULT = 2
    """The inner joint's encoder cannot be trusted."""
    OUTER_FAULT = 4
    """The outer joint's encoder cannot be trusted."""
    OVERRUN = 8
    """The device missed an instant of sampling before this sample."""


ENCODER_FAULTS = Status.CART_FAULT | Status.INNER_FAULT | Status.OUTER_FAULT


class Sample(NamedTuple):
    """The counters of all encoders, read at one instant."""

    sequence: int
    """Number of the sample since the device started, unsigned 32 bit, rolls over."""
    time_us: int
    """The device's clock at the instant of reading [us], unsigned 32 bit, rolls over every 71.6 minutes."""
    cart: int
    """Counter of the cart's encoder, signed 32 bit, rolls over; likewise the next two."""
    inner: int
    outer: int
    status: int = 0
    """Bits of `Status`."""


class Hello(NamedTuple):
    """The device's greeting, sent when it starts and about once a second from then on."""

    period_us: int
    """Time between samples [us], unsigned 32 bit."""
    inner_counts: int
    """Counts of the inner encoder per turn, after quadrature decoding, unsigned 32 bit; likewise the next."""
    outer_counts: int
    firmware: str
    """Name and version of the firmware: printable ASCII without `,` and `*`, up to 32 characters."""


class CartCommand(NamedTuple):
    """What the host asks of the cart's drive until the next command comes, or for `WATCHDOG_SECONDS`."""

    sequence: int
    """Number of the command, unsigned 32 bit, rolls over."""
    acceleration: int
    """Of the cart [mm/s^2], positive where the cart's counter grows; signed 32 bit."""


WATCHDOG_SECONDS = 0.05
"""A drive that has had no command for so long [s] brakes."""

Record = Sample | Hello | CartCommand


def signed_32(number: int) -> int:
    """Return a number as a signed counter of 32 bit shows it; of a difference of two counters, roll-over removed."""
    return ((number + 2**31) & UNSIGNED_32) - 2**31


_FIRMWARE = re.compile(rb"[ -)+\-./0-~]{0,32}")
_LINE = re.compile(rb"\$(([A-Z])(\d{1,3}),([ -)+-~]*))\*([0-9A-Fa-f]{4})\r?")
_NUMBER = re.compile(rb"-?\d{1,10}")
_CHECKSUM = struct.Struct("<H")


class FrameError(Exception):
    """A frame's bytes are not a record; never leaves this package's rig part."""


class ChecksumError(FrameError):
    """A frame has the right form, but its checksum does not match."""


class _Kind(NamedTuple):
    """A kind of record."""

    record: type[Record]
    number: int
    """What stands for it in binary frames; likewise the next in lines."""
    letter: str
    layout: struct.Struct
    """Of version, kind and its numbers in binary frames; their ranges are those of lines, too."""

    def make(self, numbers: Sequence[int], text: bytes) -> Record:
        """Return the record of decoded fields. Raises `FrameError` where one is out of its range."""
        if self.record is Hello and min(numbers) > 0 and _FIRMWARE.fullmatch(text):
            return Hello._make([*numbers, text.decode("ascii")])
        if self.record is Hello or text:
            raise FrameError("wrong length, or a field out of its range")
        return self.record._make(numbers)


_KINDS = (
    _Kind(Hello, 0, "H", struct.Struct("<BBIII")),
    _Kind(Sample, 1, "S", struct.Struct("<BBIIiiiB")),
    _Kind(CartCommand, 2, "C", struct.Struct("<BBIi")),
)
_OF_RECORD = {kind.record: kind for kind in _KINDS}
_OF_LETTER = {kind.letter.encode(): kind for kind in _KINDS}


class Codec(ABC):
    """Turns records into frames and back. A frame ends with the delimiter, which occurs nowhere else in it."""

    name: ClassVar[str]
    delimiter: ClassVar[bytes]
    """The byte that ends a frame."""

    @abstractmethod
    def encode(self, record: Record) -> bytes:
        """Return the frame of a record, its delimiter included."""

    @abstractmethod
    def decode(self, frame: bytes) -> Record:
        """Return the record of a frame given without its delimiter. Raises `FrameError` where it is none."""


class BinaryCodec(Codec):
    """The compact codec, 27 bytes a sample: COBS frames of little-endian fields with a checksum."""

    name = "binary"
    delimiter = b"\x00"

    def encode(self, record: Record) -> bytes:
        """See `Codec`."""
        kind = _OF_RECORD[type(record)]
        numbers, text = (record[:-1], record.firmware) if isinstance(record, Hello) else (record, "")
        body = kind.layout.pack(PROTOCOL_VERSION, kind.number, *numbers) + text.encode("ascii")
        return bytes(cobs.encode(body + _CHECKSUM.pack(checksum(body)))) + self.delimiter

    def decode(self, frame: bytes) -> Record:
        """See `Codec`."""
        try:
            data = cobs.decode(frame)
        except cobs.DecodeError as error:
            raise FrameError("not a COBS frame") from error
        body = data[: -_CHECKSUM.size]
        if len(body) < 2:
            raise FrameError("too short")
        if checksum(body) != _CHECKSUM.unpack(data[-_CHECKSUM.size :])[0]:
            raise ChecksumError
        _check_version(body[0])
        try:
            kind = _KINDS[body[1]]
            _, _, *numbers = kind.layout.unpack_from(body)
        except (IndexError, struct.error) as error:
            raise FrameError("unknown kind or length") from error
        return kind.make(numbers, body[kind.layout.size :])


class TextCodec(Codec):
    """The codec for rigs driven by a short sketch: one line a sample with a checksum, readable in any terminal."""

    name = "text"
    delimiter = b"\n"

    def encode(self, record: Record) -> bytes:
        """See `Codec`."""
        letter = _OF_RECORD[type(record)].letter
        body = ",".join([f"{letter}{PROTOCOL_VERSION}", *map(str, record)]).encode("ascii")
        return b"$%s*%04X\r\n" % (body, checksum(body))

    def decode(self, frame: bytes) -> Record:
        """See `Codec`."""
        line = _LINE.fullmatch(frame)
        if line is None:
            raise FrameError("not a line of the protocol")
        body, letter, version, fields, check = line.groups()
        if checksum(body) != int(check, 16):
            raise ChecksumError
        _check_version(int(version))
        kind, values = _OF_LETTER.get(letter), fields.split(b",")
        text = values.pop() if kind and kind.record is Hello else b""
        if kind is None or not all(map(_NUMBER.fullmatch, values)):
            raise FrameError("unknown kind, or a field that is no number")
        numbers = [int(value) for value in values]
        try:
            kind.layout.pack(PROTOCOL_VERSION, kind.number, *numbers)
        except struct.error as error:
            raise FrameError("wrong count or range of fields") from error
        return kind.make(numbers, text)


CODECS: dict[str, type[Codec]] = {codec.name: codec for codec in (BinaryCodec, TextCodec)}
"""Both by their names."""


def checksum(data: bytes) -> int:
    """Return the CRC-16 of both codecs: polynomial 0x1021, start 0xFFFF, not reflected (CRC-16/IBM-3740).

    Its value for b"123456789" is 0x29B1.
    """
    return crc_hqx(data, 0xFFFF)


def _check_version(version: int) -> None:
    if version != PROTOCOL_VERSION:
        raise FrameError(f"protocol version {version}")


class Commands:
    """Numbers commands, in the order in which they are sent."""

    def __init__(self, codec: Codec, cart_sign: int) -> None:
        """`cart_sign` is -1 where the cart's counter runs against its positive direction."""
        self._codec, self._sign, self._sequence = codec, cart_sign, 0

    def frame(self, acceleration: float) -> bytes:
        """Return the frame of the next command [m/s^2]; none of one that is no finite number: the drive then brakes."""
        if not math.isfinite(acceleration):
            return b""
        self._sequence = (self._sequence + 1) & UNSIGNED_32
        largest = 2**31 - 1
        in_mm = round(min(max(1e3 * self._sign * acceleration, -largest), largest))
        return self._codec.encode(CartCommand(self._sequence, in_mm))
