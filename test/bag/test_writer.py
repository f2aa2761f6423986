# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags that a reader of others reads, with their origin; those whose recorder was killed become bags again."""

import os
import shutil
import subprocess
import sys

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state, typestore
from cdp_ident.bag.limits import Budget
from cdp_ident.bag.mcap_scan import McapScan
from cdp_ident.bag.metadata import OFFERED_QOS_PROFILES, Metadata
from cdp_ident.bag.writer import BagWriter, complete_bag, is_incomplete
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


TOPIC = "/joint_states"
PERIOD = 5_000_000
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


@pytest.fixture
def whole(tmp_path):
    """A complete bag of 10 chunks with 100 messages each."""
    with BagWriter(tmp_path / "whole") as writer:
        for i in range(1000):
            stamp = (i + 1) * PERIOD
            writer.write(TOPIC, MESSAGE_TYPE, stamp, serialize_joint_state(["a"], [float(i)], stamp))
            if i % 100 == 99:
                writer.flush()
    return tmp_path / "whole"


def killed_at(whole, size):
    """A copy of the bag as if its recorder had been killed when the file had this many bytes."""
    killed = whole.parent / "killed"
    killed.mkdir()
    (killed / "killed_0.mcap").write_bytes((whole / "whole_0.mcap").read_bytes()[:size])
    return killed


def positions(bag):
    with AnyReader([bag]) as reader:
        return [reader.deserialize(raw, c.msgtype).position[0] for c, _, raw in reader.messages()]


@pytest.mark.parametrize("share", [0.2, 0.5, 0.7])
def test_every_complete_chunk_is_kept(whole, share):
    size = (whole / "whole_0.mcap").stat().st_size
    killed = killed_at(whole, int(size * share))
    assert (is_incomplete(whole), is_incomplete(killed)) == (False, True)
    salvaged = complete_bag(killed)
    found = positions(killed)
    assert found == [float(i) for i in range(salvaged.messages)]
    assert salvaged.messages % 100 == 0
    assert salvaged.messages > 0
    assert "bytes at the end are not readable" in salvaged.damage
    assert salvaged.span == pytest.approx((salvaged.messages - 1) * PERIOD * 1e-9)
    assert not is_incomplete(killed)
    metadata = yaml.safe_load((killed / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert metadata["message_count"] == salvaged.messages
    assert f"{salvaged.messages} messages" in metadata["custom_data"]["salvaged"]
    assert sorted(file.name for file in killed.iterdir()) == ["killed_0.mcap", "metadata.yaml"]


def test_topics_keep_their_type_hash_and_what_was_offered(tmp_path):
    offered = [{**OFFERED_QOS_PROFILES[0], "reliability": "best_effort"}]
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/thing", "own_msgs/msg/Thing", ("ros2msg", b"float64 x"), "RIHS01_own", offered)
        writer.write("/thing", "own_msgs/msg/Thing", PERIOD, bytes(12))
    (tmp_path / "bag/metadata.yaml").unlink()
    complete_bag(tmp_path / "bag")
    metadata = yaml.safe_load((tmp_path / "bag/metadata.yaml").read_text())["rosbag2_bagfile_information"]
    (topic,) = (entry["topic_metadata"] for entry in metadata["topics_with_message_count"])
    assert topic["type_description_hash"] == "RIHS01_own"
    assert topic["offered_qos_profiles"][0]["reliability"] == "best_effort"


def test_only_the_metadata_missing_loses_nothing(whole):
    (whole / "metadata.yaml").unlink()
    salvaged = complete_bag(whole)
    assert (salvaged.messages, salvaged.damage) == (1000, "")
    assert positions(whole) == [float(i) for i in range(1000)]


@pytest.mark.parametrize("chunk", [1, 4])
def test_a_damaged_chunk_is_left_out_and_the_old_file_kept(whole, chunk):
    file = whole / "whole_0.mcap"
    damaged = bytearray(file.read_bytes())
    compressed = -1
    for _ in range(chunk):
        compressed = damaged.index(ZSTD_MAGIC, compressed + 1)
    damaged[compressed + 50] ^= 0x10
    file.write_bytes(damaged)
    (whole / "metadata.yaml").unlink()
    salvaged = complete_bag(whole)
    assert "1 chunk(s) that are damaged" in salvaged.damage
    assert salvaged.messages == 900
    assert len(positions(whole)) == 900
    assert (whole / "whole_0.mcap.damaged").read_bytes() == damaged


def test_a_bag_still_being_recorded_is_left_alone(tmp_path):
    writer = BagWriter(tmp_path / "live")
    writer.write(TOPIC, MESSAGE_TYPE, 1, serialize_joint_state(["a"], [0.0], 1))
    writer.flush()
    with pytest.raises(BagError, match="still being recorded"):
        complete_bag(tmp_path / "live")
    writer.close()
    assert positions(tmp_path / "live") == [0.0]


def test_a_disk_without_room_leaves_the_bag_as_it_was(whole):
    killed = killed_at(whole, (whole / "whole_0.mcap").stat().st_size // 2)
    before = (killed / "killed_0.mcap").read_bytes()
    code = (
        "import resource, signal, sys; from pathlib import Path; from cdp_ident.bag.writer import complete_bag\n"
        "from cdp_ident.errors import BagError\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try:\n    complete_bag(Path(sys.argv[1]))\nexcept BagError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-B", "-c", code, killed], capture_output=True, text=True, check=True)
    assert "cannot be written" in done.stdout
    assert [file.name for file in killed.iterdir()] == ["killed_0.mcap"]
    assert (killed / "killed_0.mcap").read_bytes() == before


def test_a_salvage_that_was_itself_killed_is_begun_again(whole):
    killed = killed_at(whole, (whole / "whole_0.mcap").stat().st_size // 2)
    shutil.copytree(whole, killed / f".cdp_ident-{'0' * 16}")
    salvaged = complete_bag(killed)
    assert len(positions(killed)) == salvaged.messages
    assert sorted(path.name for path in killed.iterdir()) == ["killed_0.mcap", "metadata.yaml"]


def test_links_and_folders_with_names_of_what_is_completed_are_neither_followed_nor_removed(whole, tmp_path):
    content = bytearray((whole / "whole_0.mcap").read_bytes())
    content[len(content) // 2] ^= 1
    killed = killed_at(whole, len(content) - 100)
    (killed / "killed_0.mcap").write_bytes(content[:-100])
    (tmp_path / "secret").write_text("mine")
    planted = (".metadata.yaml", "metadata.yaml", "killed_0.mcap.damaged", f".cdp_ident-{'0' * 16}")
    for name in planted:
        (killed / name).symlink_to(tmp_path / "secret")
    (killed / ".salvage").mkdir()
    salvaged = complete_bag(killed)
    assert len(positions(killed)) == salvaged.messages
    assert (tmp_path / "secret").read_text() == "mine"
    assert (killed / ".salvage").is_dir()


def test_a_file_with_nothing_in_it_is_named(tmp_path):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.mcap").write_bytes(b"")
    with pytest.raises(BagError, match=r"bag_0\.mcap is empty"):
        complete_bag(tmp_path / "bag")
    assert (tmp_path / "bag" / "bag_0.mcap").exists()


def test_a_cut_at_any_byte_gives_a_prefix_of_the_messages(whole, tmp_path):
    content = (whole / "whole_0.mcap").read_bytes()
    file = tmp_path / "cut.mcap"
    counts = []
    for size in range(17, len(content), max(1, len(content) // 300)):
        file.write_bytes(content[:size])
        try:
            stamps = [stamp for _, _, stamp, _ in McapScan(file, Budget(file, 0)).messages()]
        except BagError:
            stamps = []
        assert stamps == [(i + 1) * PERIOD for i in range(len(stamps))]
        counts.append(len(stamps))
    assert counts == sorted(counts)
    assert counts[-1] == 1000


def with_custom_data(folder, custom):
    with BagWriter(folder) as writer:
        writer.write(TOPIC, MESSAGE_TYPE, START + 5, b"\0\1\0\0")
        writer.close(custom)
    return folder


def test_the_recorder_s_name_of_the_rig_and_the_start_are_read(tmp_path):
    metadata = Metadata.of(with_custom_data(tmp_path / "bag", {"rig_name": "/rig1/driver"}))
    assert (metadata.rig, metadata.start_ns) == ("/rig1/driver", START + 5)


@pytest.mark.parametrize("custom", [{}, {"rig_name": "unknown"}, {"recorder": "another"}])
def test_a_bag_without_a_rig_s_name_has_none(tmp_path, custom):
    assert Metadata.of(with_custom_data(tmp_path / "bag", custom)).rig == ""


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[1, 2]",
        "rosbag2_bagfile_information: 3",
        "rosbag2_bagfile_information: {starting_time: 4, custom_data: [rig_name]}",
        "rosbag2_bagfile_information: {starting_time: {nanoseconds_since_epoch: -1}, custom_data: {rig_name: {}}}",
        "a: &a [*a]",
    ],
)
def test_metadata_of_any_other_shape_or_none_tell_nothing(tmp_path, text):
    (tmp_path / "metadata.yaml").write_text(text)
    for metadata in (Metadata.of(tmp_path), Metadata.of(tmp_path / "nowhere")):
        assert not any((metadata.rig, metadata.start_ns, metadata.files, metadata.count(["/joint_states"])))
