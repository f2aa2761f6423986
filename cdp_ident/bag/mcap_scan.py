# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""One pass through an MCAP file that keeps every complete chunk, whether or not the file was finished."""

import os
import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import IO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.writer import MCAP0_MAGIC

from cdp_ident.bag.limits import LARGEST_CHUNK, LARGEST_SCHEMA, MOST_TOPICS, Budget, decompressed
from cdp_ident.errors import BagError
from cdp_ident.files import open_regular

ROS1_MAGIC = b"#ROSBAG"
ROS1 = "a bag of ROS 1: `rosbags-convert --src {path} --dst FOLDER` makes one of ROS 2, which identify takes"
NO_BAG = "expected a rosbag2 recording; of a table, import_csv makes one"
"""What it is that begins so, and what to do with it."""
_RECORD_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_CHUNK_BEGIN = struct.Struct("<QQQI")
"""Times of the first and the last message, size, CRC: 0 where a writer makes none."""
_CHUNK_HEAD = 64
"""Bytes of a chunk's record beside its data, and a few to spare."""
_HOLDING_MESSAGES = (Opcode.CHUNK, Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
# What the record parsers of mcap raise on bytes that are not what they should be.
_GARBLED = (McapError, struct.error, ValueError, OverflowError, MemoryError, RuntimeError)
_DAMAGED = "chunk(s) that are damaged, or claim too much, are left out"
_ORPHANED = "messages without a known topic are left out"
_LOOSE = "messages beside the chunks, without a checksum, are left out"
_NO_SCHEMA = Schema(id=0, name="", encoding="", data=b"")

Topic = tuple[Channel, Schema]
Message = tuple[Channel, Schema, int, bytes]
"""With its time of receipt [ns since the epoch], and serialised."""


class McapScan:
    """The messages of one MCAP file in the order of the file, and afterwards what of the file could not be read.

    Chunks are checked against their CRC. A damaged chunk is left out and the pass goes on behind it; where the file
    ends early, or is no longer a sequence of records, the pass ends. The summary behind the data, which nothing
    protects, is believed only where the data do not say the same themselves. Writers put either all messages into
    chunks or none: one beside chunks comes from damage to their heads, and has no CRC. They give a CRC to all chunks or
    to none: damage has taken it from one beside as many that have it.
    """

    def __init__(self, path: Path, budget: Budget) -> None:
        """`budget` is what reading it may cost."""
        self.path = path
        self._budget = budget
        self._size = 0
        """Bytes of the file."""
        self._lost_bytes = 0
        """Those at its end that are not readable."""
        self._left_out = dict.fromkeys((_DAMAGED, _ORPHANED, _LOOSE), 0)
        """How many of each kind."""
        self._topics: dict[int, Topic] = {}
        """Of the data, by the number of the channel."""
        self._repeated: dict[int, Topic] = {}
        """By the summary."""
        self._schemas: dict[int, Schema] = {}
        self._ended = False
        """Whether the pass is behind the data."""
        self._has_chunks = False
        self._checksums = 0
        """Chunks with a CRC less those without."""

    def messages(self) -> Iterator[Message]:
        """Yield every readable message.

        Raises BagError where the file cannot be opened or is not an MCAP file.
        """
        try:
            with open_regular(self.path) as stream:
                self._size = os.fstat(stream.fileno()).st_size
                begin = stream.read(len(MCAP0_MAGIC))
                if begin.startswith(ROS1_MAGIC):
                    raise BagError(f"{self.path} is {ROS1.format(path=self.path)}")
                if begin != MCAP0_MAGIC:
                    what = "is empty" if self._size == 0 else "is not an MCAP file"
                    raise BagError(f"{self.path} {what}: {NO_BAG}")
                # A finished file repeats its topics behind the data: they are then known whatever chunk is damaged.
                for opcode, record in self._records(stream, (Opcode.SCHEMA, Opcode.CHANNEL)):
                    self._declare(opcode, record, self._repeated)
                self._schemas.clear()
                stream.seek(len(MCAP0_MAGIC))
                for opcode, record in self._records(stream, _HOLDING_MESSAGES):
                    if opcode == Opcode.CHUNK:
                        yield from self._chunk(record)
                    elif opcode == Opcode.MESSAGE and self._has_chunks:
                        self._left_out[_LOOSE] += 1
                    elif opcode == Opcode.MESSAGE or not self._ended:
                        yield from self._read(opcode, record)
        except OSError as error:
            raise BagError(f"{self.path} cannot be read: {error.strerror or error}") from error

    def _records(self, stream: IO[bytes], wanted: tuple[Opcode, ...]) -> Iterator[tuple[int, bytes]]:
        """Yield kind and content of the complete records of some kinds; the others are passed over unread."""
        self._ended = False
        end = stream.tell()
        while len(head := stream.read(_RECORD_HEAD.size)) == _RECORD_HEAD.size:
            opcode, length = _RECORD_HEAD.unpack(head)
            # Opcode 0 is no record: a file system that was cut off from its power leaves zeros.
            if opcode == 0 or length > self._size - end - _RECORD_HEAD.size:
                break
            end += _RECORD_HEAD.size + length
            self._ended = self._ended or opcode in (Opcode.DATA_END, Opcode.FOOTER)
            self._has_chunks = self._has_chunks or opcode == Opcode.CHUNK
            self._budget.spend(records=1)
            if opcode == Opcode.CHUNK and opcode not in wanted and length >= _CHUNK_BEGIN.size:
                *_, checksum = _CHUNK_BEGIN.unpack(stream.read(_CHUNK_BEGIN.size))
                self._checksums += 1 if checksum else -1
            elif opcode in wanted and length <= LARGEST_CHUNK + _CHUNK_HEAD:
                yield opcode, stream.read(length)
            elif opcode == Opcode.CHUNK:
                self._left_out[_DAMAGED] += Opcode.CHUNK in wanted
            if opcode == Opcode.FOOTER:
                break
            stream.seek(end)
        # Behind the data there is only the index, which this pass does without.
        self._lost_bytes = 0 if self._ended else self._size - end

    def _chunk(self, record: bytes) -> Iterator[Message]:
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(record)))
            if chunk.uncompressed_crc == 0 and self._checksums >= 0:
                raise ValueError("a chunk without a CRC beside others with one")
            data = _uncompressed(chunk, self._budget)
            count = sum(1 for _ in _records_in(data))
        except _GARBLED:
            self._left_out[_DAMAGED] += 1
            return
        self._budget.spend(records=count)
        for opcode, start, end in _records_in(data):
            yield from self._read(opcode, data[start:end])

    def _read(self, opcode: int, record: bytes) -> Iterator[Message]:
        """Take a declaration, or yield a message; count it where its topic is not known."""
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            self._declare(opcode, record, self._topics)
        elif opcode == Opcode.MESSAGE:
            if len(record) >= _MESSAGE_HEAD.size:
                number, _, log_time, _ = _MESSAGE_HEAD.unpack_from(record)
                # The declaration of one that only the summary knows stood in a chunk that is damaged.
                topic = self._topics.get(number) or self._repeated.get(number)
                if topic and log_time < 2**63:
                    yield *topic, log_time, record[_MESSAGE_HEAD.size :]
                    return
            self._left_out[_ORPHANED] += 1

    def _declare(self, opcode: int, record: bytes, topics: dict[int, Topic]) -> None:
        if len(record) > LARGEST_SCHEMA:
            return
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(ReadDataStream(BytesIO(record)))
                if schema.id in self._schemas or len(self._schemas) < MOST_TOPICS:
                    self._schemas[schema.id] = schema
            else:
                channel = Channel.read(ReadDataStream(BytesIO(record)))
                if channel.id in topics or len(topics) < MOST_TOPICS:
                    topics[channel.id] = channel, self._schemas.get(channel.schema_id, _NO_SCHEMA)
        except _GARBLED:
            return  # its messages are then counted as orphaned

    def types(self) -> dict[str, str]:
        """Return the message type of each topic of the pass, now at its end."""
        return {channel.topic: schema.name for channel, schema in (*self._repeated.values(), *self._topics.values())}

    @property
    def lacks_more_than_its_end(self) -> bool:
        """Whether the pass, now at its end, has left out something."""
        return any(self._left_out.values())

    def damage(self) -> str:
        """Return in words what the pass, now at its end, could not read; empty if nothing."""
        lost = {"bytes at the end are not readable (its recorder was killed?)": self._lost_bytes}
        words = [f"{count} {what}" for what, count in (lost | self._left_out).items() if count]
        return ", ".join(words or ["it has no end (its recorder was killed?)"] * (not self._ended))


def _uncompressed(chunk: Chunk, budget: Budget) -> bytes:
    """Return the checked records of a chunk, or raise one of `_GARBLED`."""
    size = chunk.uncompressed_size
    if size > LARGEST_CHUNK:
        raise ValueError(f"a chunk of {size} bytes")
    budget.spend(unfolded=size)
    data = decompressed(chunk.data, chunk.compression, size) if chunk.compression else chunk.data
    if len(data) != size or chunk.uncompressed_crc not in (0, zlib.crc32(data)):
        raise ValueError("a chunk's records contradict its size or CRC")
    return data


def _records_in(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield kind, begin and end of each record of a chunk. Raises ValueError or struct.error where they do not fit."""
    position = 0
    while position < len(data):
        opcode, length = _RECORD_HEAD.unpack_from(data, position)
        start = position + _RECORD_HEAD.size
        position = start + length
        if position > len(data):
            raise ValueError("a record is longer than its chunk")
        yield opcode, start, position
