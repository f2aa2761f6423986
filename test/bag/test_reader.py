# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Any rosbag2 bag is read, or refused with one clear error."""

import hashlib
import os
import re
import sqlite3
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.opcode import Opcode
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from cdp_ident.bag.joint_state import HEAD_OFFSET, MESSAGE_TYPE, parse_layout, serialize_joint_state, typestore
from cdp_ident.bag.reader import bag_checksums, read_joint_states
from cdp_ident.bag.writer import BagWriter
from cdp_ident.errors import BagError
from scenarios.short_bags import COUNT, NAMES, PERIOD, POSITIONS, STAMPS, START, expect_all, fill, fill_sqlite, publish


@pytest.mark.parametrize("storage", list(StoragePlugin))
@pytest.mark.parametrize("mode", list(CompressionMode))
@pytest.mark.parametrize("metadata", [True, False])
def test_bags_of_another_writer_are_read(tmp_path, storage, mode, metadata):
    if storage is StoragePlugin.SQLITE3 and mode is CompressionMode.STORAGE:
        pytest.skip("SQLite has no compression of its own")
    writer = Writer(tmp_path / "bag", version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/joint_states", MESSAGE_TYPE, typestore=typestore())
        for stamp, position in zip(STAMPS.tolist(), POSITIONS, strict=True):
            writer.write(connection, stamp + 7, serialize_joint_state(NAMES, position, stamp))
    if not metadata:
        (tmp_path / "bag" / "metadata.yaml").unlink()
    expect_all(read_joint_states(tmp_path / "bag", "joint_states"))


def test_a_bare_file_and_metadata_stand_for_their_bag(tmp_path):
    fill(tmp_path / "swing")
    expect_all(read_joint_states(tmp_path / "swing" / "swing_0.mcap", "/joint_states"))
    recording = read_joint_states(tmp_path / "swing" / "metadata.yaml", "/joint_states")
    expect_all(recording)
    assert recording.name == "swing"


def test_a_path_with_signs_that_mean_something_to_sqlite_is_read(tmp_path):
    fill_sqlite(tmp_path / "plain").rename(tmp_path / "50% #1?")
    expect_all(read_joint_states(tmp_path / "50% #1?", "joint_states"))


def test_messages_still_in_sqlite_s_journal_are_read_and_the_bag_stays_as_it_is(tmp_path):
    bag = fill_sqlite(tmp_path / "bag", 1)
    recorder = sqlite3.connect(bag / "bag.db3")
    recorder.execute("PRAGMA journal_mode=WAL")
    raw = serialize_joint_state(NAMES, POSITIONS[1], START + PERIOD)
    recorder.execute("INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)", (START + PERIOD, raw))
    recorder.commit()
    before = {file.name: file.read_bytes() for file in bag.iterdir()}
    assert np.array_equal(read_joint_states(bag, "joint_states").stamps, STAMPS[:2])
    assert {file.name: file.read_bytes() for file in bag.iterdir()} == before
    recorder.close()


def test_the_files_of_a_split_bag_are_read_in_order(tmp_path):
    fill(tmp_path / "a", STAMPS[:30], POSITIONS[:30])
    fill(tmp_path / "b", STAMPS[30:], POSITIONS[30:])
    (tmp_path / "swing").mkdir()
    (tmp_path / "a" / "a_0.mcap").rename(tmp_path / "swing" / "swing_2.mcap")
    (tmp_path / "b" / "b_0.mcap").rename(tmp_path / "swing" / "swing_10.mcap")
    expect_all(read_joint_states(tmp_path / "swing", "joint_states"))


def test_joints_of_several_publishers_have_gaps_where_a_message_does_not_name_them(tmp_path):
    messages = [(["arm"], [1.0]), (["cart", "arm"], [2.0, 1.0])] * 10
    raw = (serialize_joint_state(*message, START + i) for i, message in enumerate(messages))
    recording = read_joint_states(publish(tmp_path / "swing", *raw), "joint_states")
    assert recording.joints == ("arm", "cart")
    assert np.all(recording.positions[:, 0] == 1.0)
    assert np.all(np.isnan(recording.positions[::2, 1]))
    assert np.all(recording.positions[1::2, 1] == 2.0)


def test_joints_that_have_a_topic_each_are_read_together(tmp_path):
    with BagWriter(tmp_path / "swing") as writer:
        for i in range(20):
            joint = ("inner", "outer")[i % 2]
            writer.write(
                f"/{joint}/joint_states", MESSAGE_TYPE, START + i, serialize_joint_state([joint], [1.0], START + i)
            )
    recording = read_joint_states(tmp_path / "swing", "/inner/joint_states outer/joint_states")
    assert recording.joints == ("inner", "outer")
    assert np.all(np.isfinite(recording.positions).sum(axis=1) == 1)
    alone = read_joint_states(tmp_path / "swing", "/inner/joint_states")
    assert alone.joints == ("inner",)
    assert alone.notes == ("joint states on /outer/joint_states are not read",)
    with pytest.raises(BagError, match="are on /inner/joint_states, /outer/joint_states: name that topic, or several"):
        read_joint_states(tmp_path / "swing", "joint_states")


def test_messages_stay_in_the_order_of_their_storage_where_the_clock_of_receipt_was_set_back(tmp_path):
    received = np.where(np.arange(COUNT) < COUNT // 2, STAMPS, STAMPS - 5 * 10**9)
    recording = read_joint_states(fill(tmp_path / "swing", received), "joint_states")
    assert np.array_equal(recording.stamps, received)


def test_what_the_metadata_counts_and_is_not_there_is_said(tmp_path):
    bag = fill(tmp_path / "swing")
    (file,) = bag.glob("*.mcap")
    content = file.read_bytes()
    ends = [at for at in range(len(content)) if content[at : at + 9] == struct.pack("<BQ", Opcode.MESSAGE_INDEX, 22)]
    file.write_bytes(content[: ends[COUNT // 2]])
    recording = read_joint_states(bag, "joint_states")
    lost = COUNT - len(recording.stamps)
    assert 0 < lost < COUNT
    assert f"{lost} of the {COUNT} messages that metadata.yaml counts are missing" in recording.notes
    (bag / "metadata.yaml").unlink()
    assert read_joint_states(bag, "joint_states").notes == (f"{file.name}: it has no end (its recorder was killed?)",)


def test_times_of_receipt_stand_beside_the_stamps(tmp_path):
    stamps = np.where(np.arange(COUNT) == 0, 0, STAMPS)
    recording = read_joint_states(fill(tmp_path / "swing", stamps), "joint_states")
    assert np.array_equal(recording.stamps, stamps)
    assert np.array_equal(recording.receipts, STAMPS + 1000)


def test_messages_that_are_no_joint_states_are_dropped_and_counted(tmp_path):
    good = serialize_joint_state(NAMES, (1.0, 2.0), START)
    count = HEAD_OFFSET + len(parse_layout(good).head) - 4
    one_position_less = good[:count] + struct.pack("<I", 1) + good[count + 4 :]
    bad = [b"", b"\0\1\0\0", good[:40], b"\0\7" + good[2:], good[:4] + b"\xff" * 8 + good[12:], one_position_less]
    recording = read_joint_states(publish(tmp_path / "swing", *bad, good), "joint_states")
    # One whose stamp is no time is as one without: the time of its receipt may do.
    assert recording.stamps.tolist() == [0, START]
    assert f"{len(bad) - 1} messages" in recording.notes[0]


@pytest.mark.parametrize(
    ("raw", "cause"),
    [
        (serialize_joint_state((), (), START), "name no joint"),
        (serialize_joint_state(("", ""), (1.0, 2.0), START), "name no joint"),
        (serialize_joint_state(("a", "a"), (1.0, 2.0), START), "name a joint twice"),
        (
            b"\0\7" + serialize_joint_state(NAMES, (1.0, 2.0), START)[2:],
            "are XCDR2 or parameter lists: expected plain CDR",
        ),
        (serialize_joint_state(NAMES, (1.0, 2.0), START)[:50], "have a text that is longer than the message"),
    ],
    ids=["no names", "empty names", "a name twice", "XCDR2", "cut"],
)
def test_where_no_message_can_be_used_the_error_says_why(tmp_path, raw, cause):
    with pytest.raises(BagError, match=f"no message on /joint_states .* 7 messages are dropped: 7 ({cause})"):
        read_joint_states(publish(tmp_path / "swing", *[raw] * 7), "joint_states")


def test_paths_that_lead_nowhere_are_the_reader_s_own_errors(tmp_path):
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "a_0.mcap").symlink_to(tmp_path / "nowhere")
    foreign = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff\x1b.db3"))
    foreign.write_bytes(b"SQLite format 3\0")
    for path in (tmp_path / "loop", tmp_path / "bag", foreign, Path("y" * 5000), Path("/x" * 2500), Path("a\0b")):
        with pytest.raises(BagError) as refused:
            read_joint_states(path, "joint_states")
        assert len(str(refused.value)) <= 1000
        assert str(refused.value).isprintable()


def test_what_rclpy_serialises_is_read(tmp_path):
    # It leaves stray bytes behind an empty last array, which readers of whole messages refuse.
    serialization = pytest.importorskip("rclpy.serialization")
    messages = pytest.importorskip("sensor_msgs.msg")
    message = messages.JointState(name=list(NAMES), position=[1.5, -2.5])
    layout = parse_layout(serialization.serialize_message(message))
    assert layout.names == NAMES
    assert layout.positions.unpack_from(serialization.serialize_message(message), layout.offset) == (1.5, -2.5)


@given(
    st.lists(st.tuples(st.text(max_size=9).filter(lambda t: "\0" not in t), st.floats(allow_nan=False)), max_size=5),
    st.text(max_size=9).filter(lambda t: "\0" not in t),
    st.sampled_from(["little", "big"]),
)
def test_positions_are_found_wherever_names_put_them(joints, frame, order):
    types = typestore().types
    message = types[MESSAGE_TYPE](
        header=types["std_msgs/msg/Header"](stamp=types["builtin_interfaces/msg/Time"](1, 2), frame_id=frame),
        name=[name for name, _ in joints],
        position=np.array([position for _, position in joints]),
        velocity=np.zeros(2),
        effort=np.zeros(0),
    )
    raw = bytes(typestore().serialize_cdr(message, MESSAGE_TYPE, little_endian=order == "little"))
    layout = parse_layout(raw)
    assert layout.names == tuple(message.name)
    assert layout.positions.unpack_from(raw, layout.offset) == tuple(message.position)


def two_rigs(bag):
    with BagWriter(bag) as writer:
        writer.add_topic("/joint_states", MESSAGE_TYPE)
        for topic in ("/rig1/states", "/rig2/states", "/rig1/joints"):
            writer.write(topic, MESSAGE_TYPE, START, serialize_joint_state(["a"], [1.0], START))
        writer.write("/chatter", "std_msgs/msg/String", 1, b"\0\1\0\0\1\0\0\0\0")


@pytest.mark.parametrize(
    ("make", "path", "topic", "message"),
    [
        (Path.mkdir, "../*", "joint_states", r"there is no bag in .* that is called \*$"),
        (Path.mkdir, "nowhere", "joint_states", "there is no bag .*nowhere"),
        (Path.mkdir, "", "joint_states", r"holds no \.mcap or \.db3"),
        (two_rigs, "", "/wrong", "no topic /wrong; joint states are on /rig1/joints, /rig1/states, /rig2/states: name"),
        (two_rigs, "", "states", "no topic /states; joint states are on .*: name that topic"),
        (two_rigs, "", "/joint_states", r"no message on /joint_states .*; joint states are on /rig1/joints, "),
        (two_rigs, "", "chatter", r"holds std_msgs/msg/String, not .*; joint states are on "),
        (lambda path: path.write_text("no recording, but long"), "", "joint_states", r"bag is not an MCAP file"),
        (lambda path: path.write_text("t,inner,outer\n0,1,2\n"), "", "a", "of a table, import_csv makes one"),
        (
            lambda path: [path.mkdir(), (path / "a.csv").touch()],
            "",
            "a",
            "no .mcap or .db3 file; .*import_csv makes one",
        ),
        (lambda path: [path.mkdir(), (path / "x.bag").touch()], "", "a", "x.bag is a bag of ROS 1: `rosbags-convert"),
        (
            lambda path: path.write_bytes(b"#ROSBAG V2.0"),
            "",
            "a",
            r"is a bag of ROS 1: `rosbags-convert --src .*bag --dst",
        ),
        (lambda path: path.with_name("bag.mcap.zstd").touch(), "../bag.mcap.zstd", "joint_states", "is empty"),
        (
            lambda path: path.with_name("b.mcap.zstd").write_bytes(b"no"),
            "../b.mcap.zstd",
            "a",
            "cannot be decompressed",
        ),
    ],
)
def test_what_cannot_be_read_is_named_with_what_is_there(tmp_path, make, path, topic, message):
    make(tmp_path / "bag")
    with pytest.raises(BagError, match=message):
        read_joint_states(Path(os.path.normpath(tmp_path / "bag" / path)), topic)


def test_a_relative_topic_is_the_one_that_the_bag_has_in_whatever_namespace(tmp_path):
    recording = read_joint_states(fill(tmp_path / "swing", topic="/rig1/joint_states"), "joint_states")
    assert recording.topic == "/rig1/joint_states"
    assert recording.notes[0] == "joint states are those on /rig1/joint_states"


EFFORTS = [([], []), ([], [1.0, 2.0]), ([0.5, 0.5], [3.0, 4.0]), ([0.5, 0.5], []), ([], [9.0])]
"""Velocities and efforts of messages."""


def test_efforts_are_read_where_messages_have_as_many_as_positions(tmp_path):
    plain = typestore().deserialize_cdr(serialize_joint_state(NAMES, [0.1, 0.2], START), MESSAGE_TYPE)
    with_both = (replace(plain, velocity=np.array(velocity), effort=np.array(effort)) for velocity, effort in EFFORTS)
    raw = (bytes(typestore().serialize_cdr(message, MESSAGE_TYPE)) for message in with_both)
    found = read_joint_states(publish(tmp_path / "bag", *raw), "joint_states").efforts
    assert np.array_equal(found, [[np.nan, np.nan], [1, 2], [3, 4], [np.nan, np.nan], [np.nan, np.nan]], equal_nan=True)


@pytest.mark.parametrize("name", ["pipe", "/dev/zero", "/dev/full"])
def test_what_is_no_file_is_refused(tmp_path, name):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(BagError, match="cannot be read"):
        read_joint_states(tmp_path / name, "joint_states")


def test_hidden_files_of_other_systems_are_no_part_of_a_bag(tmp_path):
    fill(tmp_path / "swing")
    (tmp_path / "swing" / "._swing_0.mcap").write_bytes(b"\x00\x05\x16\x07\x00\x02\x00\x00Mac OS X")
    expect_all(read_joint_states(tmp_path / "swing", "joint_states"))


def test_files_that_the_metadata_do_not_name_are_not_read_and_those_that_are_not_there_are_told(tmp_path):
    bag = tmp_path / "swing"
    fill(bag, STAMPS[:30], POSITIONS[:30])
    fill(tmp_path / "other", STAMPS[30:], POSITIONS[30:])
    (tmp_path / "other" / "other_0.mcap").rename(bag / "other_0.mcap")
    names = "relative_file_paths: [swing_0.mcap, swing_1.mcap]"
    (bag / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {{{names}}}")
    recording = read_joint_states(bag, "joint_states")
    assert np.array_equal(recording.stamps, STAMPS[:30])
    missing, unnamed = recording.notes
    assert "swing_1.mcap" in missing
    assert "other_0.mcap" in unnamed


@pytest.mark.parametrize(
    ("named", "place", "note"),
    [
        ("before_0.mcap", "swing_0.mcap", "no file that metadata.yaml names is there .*: read is swing_0.mcap"),
        ("parts/swing_0.mcap", "swing_0.mcap", ""),
        ("parts/swing_0.mcap", "parts/swing_0.mcap", ""),
        ("/tmp/of/the/robot/swing_0.mcap", "swing_0.mcap", ""),
    ],
)
def test_metadata_may_name_files_as_they_were_or_in_a_folder(tmp_path, named, place, note):
    fill(bag := tmp_path / "swing")
    (bag / place).parent.mkdir(exist_ok=True)
    (bag / "swing_0.mcap").rename(bag / place)
    (bag / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {{relative_file_paths: [{named}]}}")
    recording = read_joint_states(bag, "joint_states")
    assert re.fullmatch(note, "; ".join(recording.notes))
    expect_all(replace(recording, notes=()))


def test_files_outside_a_bag_are_not_read_whatever_its_metadata_name(tmp_path):
    fill(tmp_path / "other")
    (bag := tmp_path / "swing").mkdir()
    for named in ("../other/other_0.mcap", tmp_path / "other" / "other_0.mcap"):
        (bag / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {{relative_file_paths: ['{named}']}}")
        with pytest.raises(BagError, match=r"holds no \.mcap"):
            read_joint_states(bag, "joint_states")


def test_names_of_topics_are_shown_without_what_commands_a_terminal(tmp_path):
    raw = serialize_joint_state(NAMES, (0.0, 1.0), 1)
    with pytest.raises(BagError) as refused:
        read_joint_states(publish(tmp_path / "swing", raw, topic="/\x1b[2J" + "x" * 10_000), "/joint_states")
    assert "\x1b" not in str(refused.value)
    assert len(str(refused.value)) < 1000


def test_a_bag_s_files_with_messages_are_summed(tmp_path):
    (tmp_path / "b_0.mcap").write_bytes(b"one")
    (tmp_path / "b_1.mcap.zstd").write_bytes(b"two")
    (tmp_path / "metadata.yaml").write_bytes(b"changes when touched")
    sums = {name: hashlib.sha256(data).hexdigest() for name, data in (("b_0.mcap", b"one"), ("b_1.mcap.zstd", b"two"))}
    assert bag_checksums(tmp_path) == bag_checksums(tmp_path / "metadata.yaml") == sums
    assert bag_checksums(tmp_path / "b_0.mcap") == {"b_0.mcap": sums["b_0.mcap"]}
    (tmp_path / "b_2.mcap").mkdir()
    (tmp_path / "b_3.mcap").symlink_to("nowhere")
    assert bag_checksums(tmp_path) == sums  # what holds no messages is not read


def test_a_missing_bag_is_refused(tmp_path):
    with pytest.raises(BagError, match="nowhere"):
        bag_checksums(tmp_path / "nowhere")
