"""JointState without ROS."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis.strategies import integers, lists, text

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state, typestore


def test_what_was_serialised_is_read_back_by_another_reader():
    raw = serialize_joint_state(["inner_joint", "outer_joint"], [0.25, -3.5], 1_700_000_000_123_456_789)
    message = typestore().deserialize_cdr(raw, MESSAGE_TYPE)
    assert message.name == ["inner_joint", "outer_joint"]
    assert list(message.position) == [0.25, -3.5]
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1_700_000_000, 123_456_789)
    assert len(message.velocity) == len(message.effort) == 0


@given(names=lists(text(max_size=9), max_size=5), stamp=integers(0, 2**31 * 10**9 - 1))
def test_it_is_to_the_byte_what_another_writer_makes_of_it(names, stamp):
    types, empty = typestore().types, np.empty(0)
    when = types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
    positions = 0.25 * np.arange(len(names))
    message = types[MESSAGE_TYPE](types["std_msgs/msg/Header"](when, ""), names, positions, empty, empty)
    written = bytes(typestore().serialize_cdr(message, MESSAGE_TYPE))
    assert serialize_joint_state(names, positions.tolist(), stamp) == written


def test_ros_itself_reads_it():
    serialization = pytest.importorskip("rclpy.serialization")
    messages = pytest.importorskip("sensor_msgs.msg")
    raw = serialize_joint_state(["a", "bcd"], [1.0, 2.0], 5_000_000_007)
    message = serialization.deserialize_message(raw, messages.JointState)
    assert list(message.name) == ["a", "bcd"]
    assert list(message.position) == [1.0, 2.0]
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (5, 7)


def test_names_and_positions_must_be_as_many():
    with pytest.raises(ValueError, match="2 names but 1 positions"):
        serialize_joint_state(["a", "b"], [1.0], 0)
