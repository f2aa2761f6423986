# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Of a damaged bag what is intact is read, or it is refused with one clear error."""

import os
import struct
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode

from cdp_ident.bag.joint_state import serialize_joint_state
from cdp_ident.bag.reader import read_joint_states
from cdp_ident.errors import BagError
from scenarios.short_bags import COUNT, NAMES, POSITIONS, STAMPS, START, fill, fill_sqlite, publish


def test_a_killed_bag_is_read_up_to_its_last_complete_chunk_and_not_changed(tmp_path):
    file = fill(tmp_path / "swing") / "swing_0.mcap"
    content = file.read_bytes()[: file.stat().st_size // 3]
    file.write_bytes(content)
    (tmp_path / "swing" / "metadata.yaml").unlink()
    recording = read_joint_states(tmp_path / "swing", "joint_states")
    n = len(recording.stamps)
    assert 5 < n < COUNT
    assert np.array_equal(recording.positions, POSITIONS[:n])
    assert "bytes at the end are not readable" in recording.notes[0]
    assert file.read_bytes() == content


@pytest.fixture(scope="module")
def contents(tmp_path_factory):
    """The bytes of a good file of each kind."""
    folder = tmp_path_factory.mktemp("good")
    mcap = (fill(folder / "swing") / "swing_0.mcap").read_bytes()
    return {
        "swing.mcap": mcap,
        "bag.db3": (fill_sqlite(folder / "bag") / "bag.db3").read_bytes(),
        "swing.mcap.zstd": zstandard.compress(mcap),
    }


def cut_anywhere(data, content):
    return content[: data.draw(st.integers(0, len(content)))]


def with_changed_bytes(data, content):
    changed = bytearray(content)
    changes = st.tuples(st.integers(0, len(content) - 1), st.integers(0, 255))
    for position, value in data.draw(st.lists(changes, min_size=1, max_size=8)):
        changed[position] = value
    return changed


def with_random_bytes_behind_a_good_start(data, content):
    return content[: data.draw(st.sampled_from([0, 8, 16, 100, 400]))] + data.draw(st.binary(max_size=300))


@pytest.mark.parametrize("damaged", [cut_anywhere, with_changed_bytes, with_random_bytes_behind_a_good_start])
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_damaged_file_is_read_or_refused(tmp_path, contents, damaged, data):
    name = data.draw(st.sampled_from(sorted(contents)))
    (tmp_path / name).write_bytes(damaged(data, contents[name]))
    try:
        recording = read_joint_states(tmp_path / name, "joint_states")
    except BagError:
        return
    assert recording.positions.shape == (len(recording.stamps), len(recording.joints))
    if name == "swing.mcap" and recording.joints == NAMES:
        # What passed the checksums is what was written.
        assert np.all(np.isin(recording.stamps, STAMPS))


@pytest.mark.parametrize("seed", range(8))
def test_whatever_bit_of_the_summary_flips_every_joint_state_is_read(tmp_path, seed):
    """It only repeats what the chunks say, and nothing protects it."""
    file = fill(tmp_path / "swing") / "swing_0.mcap"
    content = file.read_bytes()
    data_end = content.rindex(bytes([Opcode.DATA_END]) + struct.pack("<Q", 4), 0, len(content))
    rng = np.random.default_rng(seed)
    for _ in range(60):
        damaged = bytearray(content)
        damaged[rng.integers(data_end + 13, len(content))] ^= 1 << rng.integers(8)
        file.write_bytes(damaged)
        recording = read_joint_states(file, "joint_states")
        assert np.array_equal(recording.positions, POSITIONS)


def test_a_channel_that_only_the_summary_has_does_not_hide_that_of_the_data(tmp_path):
    file = fill(tmp_path / "swing") / "swing_0.mcap"
    content = file.read_bytes()
    at = content.rindex(b"/joint_states") - 4 - 4  # channel and schema stand before the name and its length
    file.write_bytes(content[:at] + struct.pack("<HH", 7, 9) + content[at + 4 :])
    assert np.array_equal(read_joint_states(file, "joint_states").positions, POSITIONS)


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize(
    "bad",
    [
        Path.touch,
        lambda path: path.write_bytes(b"\x00" * 100),
        lambda path: path.write_bytes(b"SQLite format 3\0?"),
        os.mkfifo,
    ],
    ids=["empty", "zeros", "broken", "pipe"],
)
def test_of_a_split_bag_with_a_bad_file_the_others_are_read_and_it_is_told(tmp_path, bad, place):
    swing = tmp_path / "swing"
    swing.mkdir()
    for k in range(3):
        part = fill(tmp_path / f"part{k}", STAMPS[20 * k : 20 * k + 20], POSITIONS[20 * k : 20 * k + 20])
        (part / f"part{k}_0.mcap").rename(swing / f"swing_{k}.mcap")
    (swing / f"swing_{place}.mcap").unlink()
    bad(swing / f"swing_{place}.mcap")
    recording = read_joint_states(swing, "joint_states")
    kept = np.arange(COUNT) // 20 != place
    assert np.array_equal(recording.stamps, STAMPS[kept])
    assert np.array_equal(recording.positions, POSITIONS[kept])
    (note,) = recording.notes
    assert note.startswith(f"nothing more is read of swing_{place}.mcap")


def test_a_split_bag_of_bad_files_alone_is_refused_and_says_why(tmp_path):
    (tmp_path / "swing").mkdir()
    for k in range(2):
        (tmp_path / "swing" / f"swing_{k}.mcap").touch()
    with pytest.raises(BagError, match=r"nothing more is read of swing_0\.mcap.*empty"):
        read_joint_states(tmp_path / "swing", "joint_states")


def test_a_message_beside_the_chunks_which_no_checksum_protects_is_left_out_and_told(tmp_path):
    """It lay in a chunk whose head is damaged, and may be damaged itself."""
    (file,) = fill(tmp_path / "bag").glob("*.mcap")
    content, place = file.read_bytes(), 8
    while content[place] != Opcode.CHUNK:
        place += 9 + struct.unpack_from("<Q", content, place + 1)[0]
    wrong = struct.pack("<HIQQ", 1, 0, START, START) + serialize_joint_state(NAMES, [7.0, 7.0], START)
    loose = struct.pack("<BQ", Opcode.MESSAGE, len(wrong)) + wrong
    for at in (place, place + 9 + struct.unpack_from("<Q", content, place + 1)[0]):
        file.write_bytes(content[:at] + loose + content[at:])
        recording = read_joint_states(file, "joint_states")
        assert np.array_equal(recording.positions, POSITIONS)
        assert "1 messages beside the chunks, without a checksum, are left out" in recording.notes[0]


@pytest.mark.parametrize("without", [[0], [1], [0, 1, 2]])
def test_a_chunk_whose_checksum_damage_has_taken_is_left_out_unless_no_chunk_has_one(tmp_path, without):
    (file,) = publish(
        tmp_path / "bag", *(serialize_joint_state(NAMES, [number, 0.0], START + number) for number in range(3))
    ).glob("*.mcap")
    content, place, chunks = bytearray(file.read_bytes()), 8, list[int]()
    while content[place] != Opcode.DATA_END:
        if content[place] == Opcode.CHUNK:
            chunks.append(place)
        place += 9 + struct.unpack_from("<Q", content, place + 1)[0]
    for chunk in without:
        checksum = slice(chunks[chunk] + 9 + 24, chunks[chunk] + 9 + 28)
        assert any(content[checksum])
        content[checksum] = bytes(4)
    file.write_bytes(content)
    recording = read_joint_states(file, "joint_states")
    kept = {0, 1, 2} if len(without) == 3 else {0, 1, 2} - set(without)
    assert set(recording.positions[:, 0]) == kept
    assert [note for note in recording.notes if "1 chunk(s) that are damaged" in note] or len(kept) == 3
