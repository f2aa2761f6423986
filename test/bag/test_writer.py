# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags that a reader of others reads."""

import os

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state, typestore
from cdp_ident.bag.salvage import is_incomplete
from cdp_ident.bag.writer import BagWriter
from cdp_ident.errors import BagError

NAMES = ("inner_joint", "outer_joint")
START = 1_700_000_000_000_000_000


def write_samples(writer, count, topic="/joint_states"):
    for i in range(count):
        stamp = START + i * 5_000_000
        writer.write(topic, MESSAGE_TYPE, stamp, serialize_joint_state(NAMES, (0.1 * i, -0.1 * i), stamp))


def test_a_closed_bag_is_read_by_rosbags(tmp_path):
    with BagWriter(tmp_path / "swing") as writer:
        write_samples(writer, 50)
        writer.flush()
        write_samples(writer, 30, "/simulated/joint_states")
        writer.close({"rig": "twin"})
    with AnyReader([tmp_path / "swing"]) as reader:
        assert {name: topic.msgcount for name, topic in reader.topics.items()} == {
            "/joint_states": 50,
            "/simulated/joint_states": 30,
        }
        assert reader.start_time == START
        assert reader.duration == 49 * 5_000_000 + 1
        connection = next(c for c in reader.connections if c.topic == "/joint_states")
        assert "float64[] position" in connection.msgdef.data
        assert [profile.depth for profile in connection.ext.offered_qos_profiles] == [10]
        messages = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages([connection])]
        assert [m.position[0] for m in messages] == [0.1 * i for i in range(50)]
        assert reader.readers[0].custom_data == {"rig": "twin"}


def test_the_file_has_an_index_and_checksums_that_hold(tmp_path):
    with BagWriter(tmp_path / "swing") as writer:
        write_samples(writer, 50)
        writer.flush()
        write_samples(writer, 50)
    with (tmp_path / "swing" / "swing_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        assert len(reader.get_summary().chunk_indexes) == 2
        assert reader.get_summary().statistics.message_count == 100
        assert [message.sequence for _, _, message in reader.iter_messages(log_time_order=False)] == list(range(100))


def test_metadata_has_what_rosbag2_of_jazzy_asks_for(tmp_path):
    with BagWriter(tmp_path / "swing") as writer:
        write_samples(writer, 3)
    information = yaml.safe_load((tmp_path / "swing" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["version"] == 9
    assert information["relative_file_paths"] == ["swing_0.mcap"]
    assert information["files"][0]["message_count"] == information["message_count"] == 3
    topic = information["topics_with_message_count"][0]["topic_metadata"]
    assert topic["type_description_hash"] == typestore().hash_rihs01(MESSAGE_TYPE)
    assert topic["offered_qos_profiles"][0]["reliability"] == "reliable"


def test_an_empty_bag_is_still_a_bag(tmp_path):
    BagWriter(tmp_path / "empty").close()
    with AnyReader([tmp_path / "empty"], default_typestore=typestore()) as reader:
        assert reader.message_count == 0


def test_an_existing_folder_is_never_overwritten(tmp_path):
    (tmp_path / "swing").mkdir()
    with pytest.raises(BagError, match="not overwritten"):
        BagWriter(tmp_path / "swing")


def test_a_place_that_cannot_be_written_is_a_bag_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BagError, match="cannot be written"):
        BagWriter(tmp_path / "file" / "swing")


def test_a_full_disk_is_a_bag_error(tmp_path):
    writer = BagWriter(tmp_path / "swing")
    write_samples(writer, 20_000)
    full = os.open("/dev/full", os.O_WRONLY)
    os.dup2(full, writer._stream.fileno())
    os.close(full)
    with pytest.raises(BagError, match="cannot be written: No space left"):
        writer.flush()
    with pytest.raises(BagError, match="a write to it failed before"):
        write_samples(writer, 1)
    with pytest.raises(BagError, match="incomplete"):
        writer.close()
    assert is_incomplete(tmp_path / "swing")


@pytest.mark.parametrize("stamp", [-1, 2**63])
def test_a_stamp_that_no_clock_gives_is_refused(tmp_path, stamp):
    with BagWriter(tmp_path / "swing") as writer, pytest.raises(BagError, match="time"):
        writer.write("/joint_states", MESSAGE_TYPE, stamp, serialize_joint_state(NAMES, (0.0, 0.0), 0))


def test_an_unknown_message_type_is_named(tmp_path):
    with BagWriter(tmp_path / "swing") as writer, pytest.raises(BagError, match="my_msgs/msg/Own"):
        writer.write("/own", "my_msgs/msg/Own", START, b"\0\1\0\0")


def test_a_topic_keeps_its_type(tmp_path):
    with BagWriter(tmp_path / "swing") as writer:
        write_samples(writer, 1)
        with pytest.raises(BagError, match="std_msgs/msg/String cannot go there"):
            writer.write("/joint_states", "std_msgs/msg/String", START, b"\0\1\0\0")
