"""Records as COBS frames of little-endian fields with a CRC-16; docs/reference/protocol.md, "Binary frames"."""

import struct

from cobs import cobs

from cdp_ident.rig.codec import ChecksumError, FrameError, checksum, hello_or_error
from cdp_ident.rig.records import PROTOCOL_VERSION, CartCommand, Record, Sample

_HELLO, _SAMPLE, _COMMAND = 0, 1, 2
_HEAD = struct.Struct("<BB")
_SAMPLE_FIELDS = struct.Struct("<BBIIiiiB")
_HELLO_FIELDS = struct.Struct("<BBIII")
_COMMAND_FIELDS = struct.Struct("<BBIi")
_CHECKSUM = struct.Struct("<H")


class BinaryCodec:
    """The compact codec: 27 bytes a sample."""

    name = "binary"
    delimiter = b"\x00"

    def encode(self, record: Record) -> bytes:
        """Return the frame of a record, its delimiter included."""
        if isinstance(record, Sample):
            body = _SAMPLE_FIELDS.pack(PROTOCOL_VERSION, _SAMPLE, *record)
        elif isinstance(record, CartCommand):
            body = _COMMAND_FIELDS.pack(PROTOCOL_VERSION, _COMMAND, *record)
        else:
            *numbers, firmware = record
            body = _HELLO_FIELDS.pack(PROTOCOL_VERSION, _HELLO, *numbers) + firmware.encode("ascii")
        return bytes(cobs.encode(body + _CHECKSUM.pack(checksum(body)))) + self.delimiter

    def decode(self, frame: bytes) -> Record:
        """Return the record of a frame given without its delimiter. Raises `FrameError` where it is none."""
        try:
            data = cobs.decode(frame)
        except cobs.DecodeError as error:
            raise FrameError("not a COBS frame") from error
        if len(data) < _HEAD.size + _CHECKSUM.size:
            raise FrameError("too short")
        body = data[: -_CHECKSUM.size]
        if checksum(body) != _CHECKSUM.unpack(data[-_CHECKSUM.size :])[0]:
            raise ChecksumError
        version, kind = _HEAD.unpack_from(body)
        if version != PROTOCOL_VERSION:
            raise FrameError(f"protocol version {version}")
        if kind == _SAMPLE and len(body) == _SAMPLE_FIELDS.size:
            return Sample(*_SAMPLE_FIELDS.unpack(body)[2:])
        if kind == _COMMAND and len(body) == _COMMAND_FIELDS.size:
            return CartCommand(*_COMMAND_FIELDS.unpack(body)[2:])
        if kind == _HELLO and len(body) >= _HELLO_FIELDS.size:
            _, _, period_us, inner_counts, outer_counts = _HELLO_FIELDS.unpack_from(body)
            return hello_or_error(period_us, inner_counts, outer_counts, body[_HELLO_FIELDS.size :])
        raise FrameError("unknown kind or length")
