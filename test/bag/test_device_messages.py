# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""TimeReference and DiagnosticArray messages without ROS, and the device's own time in bags."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.bag.device_messages import (
    CLOCK_RATE,
    CLOCK_RATE_STD,
    DIAGNOSTICS,
    TIME_REFERENCE,
    parse_time_reference,
    read_statuses,
    serialize_time_reference,
)
from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.reader import read_joint_states
from cdp_ident.bag.writer import BagWriter
from scenarios.device_messages import diagnostics, time_reference

EPOCH = 1_700_000_000_000_000_000
STAMPS = EPOCH + 5_000_000 * np.arange(100)
DEVICE = 7_000_000_000 + 5_000_001 * np.arange(100)
OWN = [
    ("/time_reference", stamp, device, "one") for stamp, device in zip(STAMPS.tolist(), DEVICE.tolist(), strict=True)
]
RATES = {"one": "10.0", "other": "20.0"}


def bag(folder, references, statuses=()):
    """Write joint states at STAMPS, time references (topic, stamp, device, source) and the rates of some devices."""
    with BagWriter(folder) as writer:
        for stamp in STAMPS.tolist():
            writer.write("/joint_states", MESSAGE_TYPE, stamp, serialize_joint_state(["a", "b"], [1.0, 2.0], stamp))
        for topic, stamp, device, source in references:
            raw = time_reference(stamp, device, source)
            writer.write(topic, TIME_REFERENCE, stamp, raw)
        for source in statuses:
            values = {CLOCK_RATE: RATES[source], CLOCK_RATE_STD: "0.5"}
            raw = diagnostics({"/driver": values}, source)
            writer.write("/diagnostics", DIAGNOSTICS, EPOCH, raw)
    return read_joint_states(folder, "joint_states")


def test_each_sample_has_the_device_s_time_and_the_rate_is_that_device_s(tmp_path):
    recording = bag(tmp_path / "bag", reversed(OWN), ["other", "one", "other"])
    assert np.array_equal(recording.device, DEVICE)
    assert recording.device_rate == pytest.approx((10e-6, 0.5e-6))


def test_a_few_samples_without_it_are_dropped(tmp_path):
    recording = bag(tmp_path / "bag", OWN[3:-1])
    assert np.array_equal(recording.stamps, STAMPS[3:-1])
    assert len(recording.positions) == len(recording.device) == 96
    assert recording.device_rate is None
    assert recording.notes == ("4 samples without the device's own time are dropped",)


def test_time_references_of_something_else_are_left_alone(tmp_path):
    recording = bag(tmp_path / "bag", [("/gps/time", stamp + 1000, device, "gps") for _, stamp, device, _ in OWN])
    assert recording.device is None
    assert len(recording.stamps) == 100


def test_of_two_rigs_it_is_that_of_the_samples(tmp_path):
    other = [("/rig2/time_reference", s + 77, 0, "other") for s in STAMPS.tolist()]
    recording = bag(tmp_path / "bag", other + OWN, ["one", "other"])
    assert np.array_equal(recording.device, DEVICE)
    assert recording.device_rate == pytest.approx((10e-6, 0.5e-6))


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


def test_every_status_is_read():
    first, second = read_statuses(diagnostics({"/camera": {}, "/rig1/driver": {"lost": "3"}}, "firmware on /dev/tty"))
    assert (first.name, first.clock_rate) == ("/camera", None)
    assert (second.name, second.hardware_id, second.values) == ("/rig1/driver", "firmware on /dev/tty", {"lost": "3"})


@pytest.mark.parametrize(
    ("rate", "std", "expected"),
    [
        ("-12.5", "0.5", pytest.approx((-12.5e-6, 0.5e-6))),
        ("unknown", "unknown", None),
        ("nan", "1.0", None),
        ("1.0", "inf", None),
        ("1.0", "-1.0", None),
        ("1e6", "1.0", None),
    ],
)
def test_a_clock_s_rate_is_taken_where_it_is_one(rate, std, expected):
    (status,) = read_statuses(diagnostics({"/driver": {CLOCK_RATE: rate, CLOCK_RATE_STD: std}}))
    assert status.clock_rate == expected


@given(raw=st.binary(max_size=200))
def test_arbitrary_bytes_are_no_statuses(raw):
    assert read_statuses(raw) == []
