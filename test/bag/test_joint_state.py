# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""JointState without ROS."""

import numpy as np
import pytest

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state, typestore


def test_ros_itself_reads_it():
    serialization = pytest.importorskip("rclpy.serialization")
    messages = pytest.importorskip("sensor_msgs.msg")
    raw = serialize_joint_state(["a", "bcd"], [1.0, 2.0], 5_000_000_007, [3.0, 4.0])
    message = serialization.deserialize_message(raw, messages.JointState)
    assert list(message.velocity) == [3.0, 4.0]
    assert list(message.name) == ["a", "bcd"]
    assert list(message.position) == [1.0, 2.0]
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (5, 7)


@pytest.mark.parametrize("names", [(), ("a",), ("ä", "bc"), ("abcdefg", "h", "cart_joint")])
@pytest.mark.parametrize("moving", [False, True])
def test_the_bytes_are_those_of_another_writer(names, moving):
    positions, velocities = np.arange(len(names)) + 0.5, np.arange(len(names) if moving else 0) - 7.0
    types = typestore().types
    stamp = types["builtin_interfaces/msg/Time"](sec=-3, nanosec=7)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
    message = types[MESSAGE_TYPE](header, list(names), positions, velocities, np.empty(0))
    raw = serialize_joint_state(names, positions.tolist(), -2_999_999_993, velocities.tolist())
    assert raw == bytes(typestore().serialize_cdr(message, MESSAGE_TYPE))


def test_names_and_positions_must_be_as_many():
    with pytest.raises(ValueError, match="2 names but 1 positions"):
        serialize_joint_state(["a", "b"], [1.0], 0)
