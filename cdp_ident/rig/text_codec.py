"""Records as lines of text with a checksum; docs/reference/protocol.md, "Text lines"."""

import re

from cdp_ident.rig.codec import ChecksumError, FrameError, checksum, hello_or_error, is_valid
from cdp_ident.rig.records import PROTOCOL_VERSION, CartCommand, Hello, Record, Sample

_KINDS = {Hello: "H", Sample: "S", CartCommand: "C"}
_OF_NUMBERS: dict[bytes, type[Sample] | type[CartCommand]] = {b"S": Sample, b"C": CartCommand}
_LINE = re.compile(rb"\$(([A-Z])(\d{1,3}),([ -)+-~]*))\*([0-9A-Fa-f]{4})\r?")
_UNSIGNED = re.compile(rb"\d{1,10}")
_SIGNED = re.compile(rb"-?\d{1,10}")


class TextCodec:
    """The codec for rigs driven by a short sketch: one line a sample, readable in any terminal."""

    name = "text"
    delimiter = b"\n"

    def encode(self, record: Record) -> bytes:
        """Return the line of a record, its delimiter included."""
        body = ",".join([f"{_KINDS[type(record)]}{PROTOCOL_VERSION}", *map(str, record)]).encode("ascii")
        return b"$%s*%04X\r\n" % (body, checksum(body))

    def decode(self, frame: bytes) -> Record:
        """Return the record of a line given without its delimiter. Raises `FrameError` where it is none."""
        line = _LINE.fullmatch(frame)
        if line is None:
            raise FrameError("not a line of the protocol")
        body, kind, version, fields, check = line.groups()
        if checksum(body) != int(check, 16):
            raise ChecksumError
        if int(version) != PROTOCOL_VERSION:
            raise FrameError(f"protocol version {int(version)}")
        values = fields.split(b",")
        of_numbers = _OF_NUMBERS.get(kind)
        if of_numbers and len(values) == len(of_numbers._fields) and all(map(_SIGNED.fullmatch, values)):
            record = of_numbers(*map(int, values))
            if is_valid(record):
                return record
        if kind == b"H" and len(values) == 4 and all(_UNSIGNED.fullmatch(value) for value in values[:3]):
            return hello_or_error(int(values[0]), int(values[1]), int(values[2]), values[3])
        raise FrameError("unknown kind, count or range of fields")
