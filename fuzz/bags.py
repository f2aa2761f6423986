# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Damaged bags: read or refused with one error; of what a CRC protects not one wrong row."""

import random
import sqlite3
import struct
from contextlib import suppress
from functools import cache
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import zstandard
from mcap.exceptions import McapError
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state, typestore
from cdp_ident.bag.reader import read_joint_states
from cdp_ident.bag.writer import complete_bag
from cdp_ident.errors import BagError
from fuzz.campaign import FindingError
from fuzz.mutation import mutated

_TOPIC, _NAMES, _ROWS, _BEGIN = "/joint_states", ("inner_joint", "outer_joint"), 200, 1_700_000_000 * 10**9


def case(generator: random.Random) -> str:
    """Damage a bag of some kind, and compare the rows that are read with those that were written."""
    ending, content = generator.choice(_bags())
    with TemporaryDirectory() as name:
        path = Path(name) / f"swing{ending}"
        damaged = mutated(content, generator)
        path.write_bytes(damaged)
        try:
            if ending == ".mcap" and generator.random() < 0.2:
                complete_bag(path.parent)
            recording = read_joint_states(path, _TOPIC)
        except BagError:
            return "refused"
    if recording.joints[:2] != _NAMES:
        wrong = len(recording.stamps)
    else:
        read = zip(recording.stamps.tolist(), map(tuple, recording.positions[:, :2].tolist()), strict=True)
        wrong = sum(row not in _rows() for row in read)
    if wrong and ending.startswith(".mcap") and not _lost_its_checksums(damaged):
        raise FindingError(f"{wrong} wrong rows in spite of a CRC")
    kind = "sqlite3" if ending == ".db3" else "MCAP"
    if wrong:
        return f"{kind}: wrong rows"
    return f"{kind}: {'all rows' if len(recording.stamps) == _ROWS else 'fewer rows'}"


def _lost_its_checksums(content: bytes) -> bool:
    """Return whether chunks are left, but no CRC of them: then the file is one of a writer that makes none."""
    checksums = list[int]()
    with suppress(McapError, struct.error, ValueError, OverflowError, MemoryError):
        for record in StreamReader(BytesIO(content), emit_chunks=True, record_size_limit=None).records:
            if isinstance(record, Chunk):
                checksums.append(record.uncompressed_crc)
    return bool(checksums) and not any(checksums)


@cache
def _rows() -> frozenset[tuple[int, tuple[float, ...]]]:
    return frozenset((stamp, tuple(position)) for stamp, position in _swing())


def _swing() -> list[tuple[int, list[float]]]:
    time = np.arange(_ROWS) / 200.0
    positions = np.column_stack([np.sin(6 * time), np.cos(11 * time)])
    return [(_BEGIN + 5_000_000 * number, position) for number, position in enumerate(positions.tolist())]


@cache
def _bags() -> tuple[tuple[str, bytes], ...]:
    """Return endings and contents of good bags: chunks of each compression, the whole file compressed, sqlite3."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        found = [(".mcap", _mcap(folder / str(kind), kind)) for kind in CompressionType]
        found += [(".mcap.zstd", zstandard.ZstdCompressor().compress(found[0][1]))]
        with Writer(folder / "sqlite", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
            connection = writer.add_connection(_TOPIC, MESSAGE_TYPE, typestore=typestore())
            for stamp, position in _swing():
                writer.write(connection, stamp, serialize_joint_state(_NAMES, position, stamp))
        (database,) = (folder / "sqlite").glob("*.db3")
        with sqlite3.connect(database) as compact:
            compact.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        return (*found, (".db3", database.read_bytes()))


def _mcap(path: Path, compression: CompressionType) -> bytes:
    with path.open("wb") as stream:
        writer = McapWriter(stream, chunk_size=4096, compression=compression)
        writer.start(profile="ros2")
        channel = writer.register_channel(_TOPIC, "cdr", writer.register_schema(MESSAGE_TYPE, "ros2msg", b""))
        for stamp, position in _swing():
            writer.add_message(channel, stamp, serialize_joint_state(_NAMES, position, stamp), stamp)
        writer.finish()
    return path.read_bytes()
