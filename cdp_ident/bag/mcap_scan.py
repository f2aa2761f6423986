"""One pass through an MCAP file that keeps every complete chunk, whether or not the file was finished."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import IO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, Footer, Message, Schema
from mcap.stream_reader import StreamReader, get_chunk_data_stream

from cdp_ident.errors import BagError

LARGEST_CHUNK = 1 << 30
"""Bytes of an uncompressed chunk that are still believed; recorders make chunks of about 1 MB."""

_RECORD_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
# What the record parsers of mcap and its decompressors raise on bytes that are not what they should be.
_GARBLED = (McapError, struct.error, ValueError, OverflowError, MemoryError, RuntimeError, zstandard.ZstdError)


@dataclass(frozen=True)
class Topic:
    """One channel of an MCAP file."""

    name: str
    message_type: str
    serialization: str
    schema: tuple[str, bytes]
    """Encoding and text of the message's definition."""


class _Bounded:
    """A stream that is never asked for more than its file holds: a garbled length must not ask for all memory."""

    def __init__(self, stream: IO[bytes], size: int) -> None:
        self._stream = stream
        self._size = size

    def read(self, length: int) -> bytes:
        return self._stream.read(min(length, self._size))


class McapScan:
    """The messages of one MCAP file in the order of the file, and afterwards what of the file could not be read.

    Chunks are checked against their CRC. A damaged chunk is left out and the pass goes on behind it; where the file
    ends early, or is no longer a sequence of records, the pass ends.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.topics: dict[int, Topic] = {}
        self.size = 0
        """Bytes of the file."""
        self.lost_bytes = 0
        """Bytes at the end of the file that are not readable."""
        self.damaged_chunks = 0
        """Chunks that are there but contradict their CRC or their format."""
        self.orphaned_messages = 0
        """Messages whose topic is not known, because its declaration stood in a damaged chunk."""
        self._schemas: dict[int, Schema] = {}

    def messages(self) -> Iterator[tuple[Topic, int, bytes]]:
        """Yield topic, time of receipt [ns since the epoch] and serialised bytes of every readable message.

        Raises BagError where the file cannot be opened or is not an MCAP file.
        """
        try:
            with self.path.open("rb") as stream:
                self.size = self.path.stat().st_size
                yield from self._records(stream)
        except OSError as error:
            raise BagError(f"{self.path} cannot be read: {error.strerror or error}") from error

    def _records(self, stream: IO[bytes]) -> Iterator[tuple[Topic, int, bytes]]:
        reader = StreamReader(_Bounded(stream, self.size), emit_chunks=True, record_size_limit=self.size)
        readable, all_data = 0, False
        try:
            for record in reader.records:
                readable = stream.tell()
                if isinstance(record, Chunk):
                    yield from self._chunk(record)
                elif isinstance(record, Message):
                    yield from self._message(record.channel_id, record.log_time, record.data)
                elif isinstance(record, Schema | Channel):
                    self._declare(record)
                elif isinstance(record, DataEnd | Footer):
                    all_data = True
        except _GARBLED as error:
            if readable == 0 and isinstance(error, InvalidMagic | EndOfFile | struct.error):
                what = "is empty" if self.size == 0 else "is not an MCAP file"
                raise BagError(f"{self.path} {what}: expected a rosbag2 recording") from error
        # Behind the data there is only the index, which this pass does without.
        self.lost_bytes = 0 if all_data else self.size - readable

    def _chunk(self, chunk: Chunk) -> Iterator[tuple[Topic, int, bytes]]:
        try:
            data = _uncompressed(chunk)
            messages = []
            position = 0
            while position < len(data):
                opcode, length = _RECORD_HEAD.unpack_from(data, position)
                start = position + _RECORD_HEAD.size
                position = start + length
                if position > len(data):
                    raise ValueError("a record is longer than its chunk")
                if opcode == Opcode.MESSAGE:
                    channel, _, log_time, _ = _MESSAGE_HEAD.unpack_from(data, start)
                    messages.append((channel, log_time, data[start + _MESSAGE_HEAD.size : position]))
                elif opcode == Opcode.CHANNEL:
                    self._declare(Channel.read(ReadDataStream(BytesIO(data[start:position]))))
                elif opcode == Opcode.SCHEMA:
                    self._declare(Schema.read(ReadDataStream(BytesIO(data[start:position]))))
        except _GARBLED:
            self.damaged_chunks += 1
            return
        for message in messages:
            yield from self._message(*message)

    def _declare(self, record: Schema | Channel) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
            return
        schema = self._schemas.get(record.schema_id, Schema(id=0, name="", encoding="", data=b""))
        self.topics[record.id] = Topic(
            record.topic, schema.name, record.message_encoding, (schema.encoding, schema.data)
        )

    def _message(self, channel: int, log_time: int, data: bytes) -> Iterator[tuple[Topic, int, bytes]]:
        if channel in self.topics and log_time < 2**63:
            yield self.topics[channel], log_time, data
        else:
            self.orphaned_messages += 1

    def damage(self) -> str:
        """Return in words what the pass, now at its end, could not read; empty if nothing."""
        parts = []
        if self.lost_bytes:
            parts.append(f"{self.lost_bytes} bytes at the end are not readable (its recorder was killed?)")
        if self.damaged_chunks:
            parts.append(f"{self.damaged_chunks} damaged chunk(s) are left out")
        if self.orphaned_messages:
            parts.append(f"{self.orphaned_messages} messages without a known topic are left out")
        return ", ".join(parts)


def _uncompressed(chunk: Chunk) -> bytes:
    """Return the checked records of a chunk, or raise one of `_GARBLED`."""
    size = chunk.uncompressed_size
    if size > LARGEST_CHUNK:
        raise ValueError(f"a chunk of {size} bytes")
    if chunk.compression == "zstd" and zstandard.frame_content_size(chunk.data) not in (size, -1):
        raise ValueError("a chunk's size contradicts its compressed data")
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    return bytes(stream.read(length))
