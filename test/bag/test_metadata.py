# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where and when a bag was recorded, by its metadata."""

import pytest

from cdp_ident.bag.metadata import Origin, origin_of
from cdp_ident.bag.writer import BagWriter


def written(folder, custom):
    with BagWriter(folder) as writer:
        writer.write("/joint_states", "sensor_msgs/msg/JointState", 1_700_000_000_000_000_005, b"\0\1\0\0")
        writer.close(custom)
    return folder


def test_the_recorder_s_name_of_the_rig_and_the_start_are_read(tmp_path):
    bag = written(tmp_path / "bag", {"rig_name": "/rig1/driver"})
    assert origin_of(bag) == Origin("/rig1/driver", 1_700_000_000_000_000_005)


@pytest.mark.parametrize("custom", [{}, {"rig_name": "unknown"}, {"recorder": "another"}])
def test_a_bag_without_a_rig_s_name_has_none(tmp_path, custom):
    assert origin_of(written(tmp_path / "bag", custom)).rig == ""


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
def test_metadata_of_any_other_shape_tell_nothing(tmp_path, text):
    (tmp_path / "metadata.yaml").write_text(text)
    assert origin_of(tmp_path) == Origin("", None)


def test_a_bag_without_metadata_tells_nothing(tmp_path):
    assert origin_of(tmp_path / "nowhere") == Origin("", None)
