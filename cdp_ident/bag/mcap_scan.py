"""One pass through an MCAP file that keeps every complete chunk, whether or not the file was finished."""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import IO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

from cdp_ident.errors import BagError

LARGEST_CHUNK = 1 << 30
"""Bytes of an uncompressed chunk that are still believed; recorders make chunks of about 1 MB."""

_RECORD_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_HOLDING_MESSAGES = (Opcode.CHUNK, Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
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
    described: Mapping[str, str]
    """What rosbag2 says of it: `offered_qos_profiles` and `topic_type_hash`."""


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
                if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                    what = "is empty" if self.size == 0 else "is not an MCAP file"
                    raise BagError(f"{self.path} {what}: expected a rosbag2 recording")
                # A finished file repeats its topics behind the data: they are then known whatever chunk is damaged.
                for opcode, record in self._records(stream, (Opcode.SCHEMA, Opcode.CHANNEL)):
                    self._declare(opcode, record)
                stream.seek(len(MCAP0_MAGIC))
                for opcode, record in self._records(stream, _HOLDING_MESSAGES):
                    if opcode == Opcode.CHUNK:
                        yield from self._chunk(record)
                    elif opcode == Opcode.MESSAGE:
                        yield from self._message(record)
                    else:
                        self._declare(opcode, record)
        except OSError as error:
            raise BagError(f"{self.path} cannot be read: {error.strerror or error}") from error

    def _records(self, stream: IO[bytes], wanted: tuple[Opcode, ...]) -> Iterator[tuple[int, bytes]]:
        """Yield kind and content of the complete records of some kinds; the others are passed over unread."""
        all_data = False
        end = stream.tell()
        while len(head := stream.read(_RECORD_HEAD.size)) == _RECORD_HEAD.size:
            opcode, length = _RECORD_HEAD.unpack(head)
            # Opcode 0 is no record: a file system that was cut off from its power leaves zeros.
            if opcode == 0 or length > self.size - end - _RECORD_HEAD.size:
                break
            end += _RECORD_HEAD.size + length
            all_data = all_data or opcode in (Opcode.DATA_END, Opcode.FOOTER)
            if opcode in wanted:
                yield opcode, stream.read(length)
            if opcode == Opcode.FOOTER:
                break
            stream.seek(end)
        # Behind the data there is only the index, which this pass does without.
        self.lost_bytes = 0 if all_data else self.size - end

    def _chunk(self, record: bytes) -> Iterator[tuple[Topic, int, bytes]]:
        messages = []
        try:
            data = _uncompressed(Chunk.read(ReadDataStream(BytesIO(record))))
            position = 0
            while position < len(data):
                opcode, length = _RECORD_HEAD.unpack_from(data, position)
                start = position + _RECORD_HEAD.size
                position = start + length
                if position > len(data):
                    raise ValueError("a record is longer than its chunk")
                if opcode == Opcode.MESSAGE:
                    messages.append(data[start:position])
                else:
                    self._declare(opcode, data[start:position])
        except _GARBLED:
            self.damaged_chunks += 1
            return
        for message in messages:
            yield from self._message(message)

    def _declare(self, opcode: int, record: bytes) -> None:
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(ReadDataStream(BytesIO(record)))
                self._schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(ReadDataStream(BytesIO(record)))
                schema = self._schemas.get(channel.schema_id, Schema(id=0, name="", encoding="", data=b""))
                definition = (schema.encoding, schema.data)
                self.topics[channel.id] = Topic(
                    channel.topic, schema.name, channel.message_encoding, definition, channel.metadata
                )
        except _GARBLED:
            return  # its messages are then counted as orphaned

    def _message(self, record: bytes) -> Iterator[tuple[Topic, int, bytes]]:
        if len(record) >= _MESSAGE_HEAD.size:
            channel, _, log_time, _ = _MESSAGE_HEAD.unpack_from(record)
            if channel in self.topics and log_time < 2**63:
                yield self.topics[channel], log_time, record[_MESSAGE_HEAD.size :]
                return
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
