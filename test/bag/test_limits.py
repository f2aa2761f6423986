# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bombs: bags of a few kilobytes that claim, or are compressed from, far more than a computer holds."""

import ast
import contextlib
import io
import sqlite3
import struct
import subprocess
import sys
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from cdp_ident.bag import limits
from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.limits import Budget, decompressed
from cdp_ident.bag.reader import read_joint_states
from cdp_ident.bag.writer import BagWriter
from cdp_ident.errors import BagError

GIGABYTE = 1 << 30
MOST_MEGABYTES = 600
"""What reading any bomb may take; Python with this package takes 100 of them."""
READ = """
import sys
from pathlib import Path
from cdp_ident.bag.reader import read_joint_states
from cdp_ident.errors import BagError
for path in sys.stdin:
    # Not `ru_maxrss`: that begins at what the process took that started this one. From here on, anew:
    Path("/proc/self/clear_refs").write_text("5")
    try:
        said = f"{len(read_joint_states(Path(path[:-1]), 'joint_states').stamps)} rows"
    except BagError as error:
        said = str(error)
    most = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    print(int(most.split()[1]) // 1024, repr(said), flush=True)
"""


def text(words):
    return struct.pack("<I", len(words)) + words.encode()


def record(opcode, body):
    return struct.pack("<BQ", opcode, len(body)) + body


def mcap(*records):
    return MCAP0_MAGIC + record(Opcode.HEADER, text("ros2") + text("")) + b"".join(records)


def chunk(compression, size, data):
    head = struct.pack("<QQQI", 0, 1, size, 0) + text(compression) + struct.pack("<Q", len(data))
    return record(Opcode.CHUNK, head + data)


def zstd_of(block, times):
    stream = io.BytesIO()
    with zstandard.ZstdCompressor().stream_writer(stream, closefd=False) as writer:
        for _ in range(times):
            writer.write(block)
    return stream.getvalue()


def lz4_of(block, times):
    compressor = lz4.frame.LZ4FrameCompressor()
    return b"".join([compressor.begin(), *(compressor.compress(block) for _ in range(times)), compressor.flush()])


DECLARED = record(Opcode.SCHEMA, struct.pack("<H", 1) + text(MESSAGE_TYPE) + text("ros2msg") + text("")) + record(
    Opcode.CHANNEL, struct.pack("<HH", 1, 1) + text("/joint_states") + text("cdr") + text("")
)
ZEROS = bytes(1 << 20)
EMPTY_RECORDS = record(Opcode.MESSAGE, b"") * (1 << 16)


def message(raw):
    return record(Opcode.MESSAGE, struct.pack("<HIQQ", 1, 0, 1, 1) + raw)


def zstd_messages(raw, times):
    """Return a chunk of messages that is itself small."""
    block = message(raw) * max(1, (1 << 20) // len(raw))
    return chunk("zstd", len(block) * times, zstd_of(block, times))


def database(path, messages):
    """Write a database of rosbag2 whose messages are made by a script."""
    with contextlib.closing(sqlite3.connect(path)) as made:
        made.executescript(
            "CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT, type TEXT);"
            f"INSERT INTO topics VALUES (1, '/joint_states', '{MESSAGE_TYPE}');{messages}"
        )


GENERATED = (
    "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
    "data BLOB AS (zeroblob(900000000))); INSERT INTO messages (topic_id, timestamp) VALUES (1, 1), (1, 2);"
)
ENDLESS = (
    "CREATE VIEW messages AS WITH RECURSIVE endless(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM endless) "
    "SELECT 1 AS topic_id, i AS timestamp, zeroblob(1000) AS data FROM endless;"
)
WIDE = serialize_joint_state([f"j{i}" for i in range(256)], [0.0] * 256, 1)
BOMBS = {
    "a chunk of zeros": ("zeros.mcap", lambda: mcap(DECLARED, chunk("zstd", GIGABYTE, zstd_of(ZEROS, 1024)))),
    "many empty records": (
        "records.mcap",
        lambda: mcap(DECLARED, chunk("zstd", len(EMPTY_RECORDS) * 50, zstd_of(EMPTY_RECORDS, 50))),
    ),
    "more than the header says": ("claim.mcap", lambda: mcap(DECLARED, chunk("zstd", 1000, zstd_of(ZEROS, 1024)))),
    "lz4": ("lz4.mcap", lambda: mcap(DECLARED, chunk("lz4", 1000, lz4_of(ZEROS, 3072)))),
    "chunk after chunk": (
        "chunks.mcap",
        lambda: mcap(DECLARED, *200 * [chunk("zstd", 100 << 20, zstd_of(ZEROS[:-9] + record(0x80, b""), 100))]),
    ),
    "the whole file": ("whole.mcap.zstd", lambda: zstd_of(ZEROS, 3072)),
    "messages that are compressed": (
        "inner.mcap",
        lambda: mcap(DECLARED, *100 * [message(zstandard.ZstdCompressor().compress(bytes(1 << 28)))]),
    ),
    "wide messages": ("wide.mcap", lambda: mcap(DECLARED, *50 * [zstd_messages(WIDE, 20)])),
    "one message of each size": (
        "names.mcap",
        lambda: mcap(
            DECLARED, *[zstd_messages(serialize_joint_state([f"n{i}{'x' * 9999}"], [0.0], 1), 1) for i in range(300)]
        ),
    ),
    "generated columns": ("generated.db3", lambda: GENERATED),
    "views": ("views.db3", lambda: ENDLESS),
}


@pytest.fixture(scope="module")
def reader():
    """A process that reads one bag after the other, and says for each what it took and found."""
    command = [sys.executable, "-c", READ]
    with subprocess.Popen(
        command, cwd=Path(__file__).parents[2], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield process
        process.stdin.close()


@pytest.mark.parametrize("bomb", BOMBS)
def test_a_bomb_takes_little_memory_and_is_one_line(tmp_path, reader, bomb):
    name, made = BOMBS[bomb]
    path = tmp_path / name
    if name.endswith(".db3"):
        database(path, made())
    else:
        path.write_bytes(made())
    assert path.stat().st_size < 20_000_000
    reader.stdin.write(f"{path}\n")
    reader.stdin.flush()
    megabytes, _, quoted = reader.stdout.readline().partition(" ")
    said = ast.literal_eval(quoted)
    assert int(megabytes) < MOST_MEGABYTES, said
    assert "\n" not in said
    assert "rows" not in said or said == "0 rows"


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_what_is_compressed_is_unfolded_up_to_its_limit(compression):
    compress = zstandard.ZstdCompressor().compress if compression == "zstd" else lz4.frame.compress
    assert decompressed(compress(ZEROS), compression, len(ZEROS)) == ZEROS
    with pytest.raises(ValueError, match="more than"):
        decompressed(compress(ZEROS), compression, len(ZEROS) - 1)
    with pytest.raises(ValueError, match="damaged"):
        decompressed(b"nonsense" * 4, compression, 100)


def test_a_large_file_may_unfold_to_more_than_a_small_one():
    Budget(Path("bag"), GIGABYTE).spend(unfolded=8 * GIGABYTE)
    with pytest.raises(BagError, match="bag unfolds to far more bytes than a file of its size should"):
        Budget(Path("bag"), 1000).spend(unfolded=8 * GIGABYTE)


def test_an_honest_bag_of_large_chunks_is_read(tmp_path, monkeypatch):
    with BagWriter(tmp_path / "swing") as writer:
        for i in range(1, 20_001):
            writer.write("/joint_states", MESSAGE_TYPE, i, serialize_joint_state(["a", "b"], [0.0, i], i))
    size = sum(file.stat().st_size for file in (tmp_path / "swing").glob("*.mcap"))
    monkeypatch.setattr(limits, "_BYTES", 0)
    monkeypatch.setattr(limits, "_BYTES_PER_BYTE", 40_000_000 // size)
    assert len(read_joint_states(tmp_path / "swing", "joint_states").stamps) == 20_000
