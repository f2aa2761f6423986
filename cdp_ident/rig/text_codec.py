"""Records as lines of text with a checksum; docs/reference/protocol.md, "Text lines"."""

import re

from cdp_ident.rig.codec import ChecksumError, FrameError, checksum, hello_or_error, is_valid
from cdp_ident.rig.records import PROTOCOL_VERSION, Record, Sample

_LINE = re.compile(rb"\$(([A-Z])(\d{1,3}),([ -)+-~]*))\*([0-9A-Fa-f]{4})\r?")
_UNSIGNED = re.compile(rb"\d{1,10}")
_SIGNED = re.compile(rb"-?\d{1,10}")


class TextCodec:
    """The codec for rigs driven by a short sketch: one line a sample, readable in any terminal."""

    name = "text"
    delimiter = b"\n"

    def encode(self, record: Record) -> bytes:
        """Return the line of a record, its delimiter included."""
        kind = "S" if isinstance(record, Sample) else "H"
        body = ",".join([f"{kind}{PROTOCOL_VERSION}", *map(str, record)]).encode("ascii")
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
        if kind == b"S" and len(values) == 6 and all(_SIGNED.fullmatch(value) for value in values):
            sample = Sample(*map(int, values))
            if is_valid(sample):
                return sample
        if kind == b"H" and len(values) == 4 and all(_UNSIGNED.fullmatch(value) for value in values[:3]):
            return hello_or_error(int(values[0]), int(values[1]), int(values[2]), values[3])
        raise FrameError("unknown kind, count or range of fields")
