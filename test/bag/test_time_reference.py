# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""TimeReference messages without ROS."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.bag.time_reference import parse_time_reference, serialize_time_reference
from scenarios.device_messages import time_reference


@pytest.mark.parametrize("frame", ["", "a", "abc", "abcd"])
def test_stamp_time_and_source_are_read_whatever_stands_between(frame):
    raw = time_reference(1_700_000_000_123_456_789, 42_000_000_007, "a device", frame)
    assert parse_time_reference(raw) == (1_700_000_000_123_456_789, 42_000_000_007, "a device")


@pytest.mark.parametrize("source", ["", "abc", "rig 1 on /dev/ttyACM0"])
def test_the_bytes_are_those_of_another_writer_up_to_zeros_at_the_end(source):
    raw = serialize_time_reference(1_700_000_000_123_456_789, 42_000_000_007, source)
    assert raw.rstrip(b"\0") == time_reference(1_700_000_000_123_456_789, 42_000_000_007, source).rstrip(b"\0")


@given(raw=st.binary(max_size=80))
def test_arbitrary_bytes_are_refused_or_a_time(raw):
    try:
        stamp, device, _ = parse_time_reference(raw)
    except (ValueError, struct.error):
        return
    assert abs(stamp) < 2**62
    assert abs(device) < 2**62
