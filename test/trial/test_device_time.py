# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The device's own time in the stamps' place."""

import numpy as np
import pytest

from cdp_ident.bag.device_messages import ClockRate
from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.trial.device_time import in_device_time

EPOCH = 1_700_000_000_000_000_000


def recorded(true, wander, fast=0.0, told=None, device=None):
    """Return a recording at true times [s] with stamps that wander [s], of a device whose clock is fast."""
    stamps = EPOCH + np.round((true + wander) * 1e9).astype(np.int64)
    times = np.round(true * (1.0 + fast) * 1e6).astype(np.int64) * 1000 if device is None else device
    positions = np.zeros((len(true), 2))
    return JointRecording("swing", "/joint_states", ("a", "b"), stamps, positions, (), times, told)


TRUE = np.arange(2600) * 0.005
WANDER = 20e-6 * np.sin(TRUE / 2.0)


def seconds(recording):
    return (recording.stamps - EPOCH) * 1e-9


def test_samples_are_as_even_as_the_device_s_clock_in_seconds_by_the_rate_that_is_told():
    told = ClockRate(1e-4, 1e-6)
    found, clock, (note,) = in_device_time(recorded(TRUE, WANDER, 1e-4, told))
    assert clock is told
    assert np.ptp(seconds(found) - TRUE) < 2e-6  # the device's microseconds
    assert abs(np.mean(seconds(found) - TRUE)) < 20e-6
    assert "100 ± 1 ppm fast" in note
    assert "us rms" in note


def test_untold_the_rate_is_that_of_the_stamps_and_as_uncertain_as_they_wander():
    found, clock, _ = in_device_time(recorded(TRUE, WANDER, -5e-3))
    assert abs(clock.fast + 5e-3) < 2.0 * clock.std
    assert 1e-6 < clock.std < 2e-5
    assert np.ptp(seconds(found) - TRUE) < 13.0 * 2.0 * clock.std


def test_a_reset_of_the_device_begins_another_run_and_no_sample_moves_by_it():
    times = np.where(TRUE < 5.0, TRUE + 100.0, TRUE - 5.0)
    found, clock, _ = in_device_time(recorded(TRUE, WANDER, device=np.round(times * 1e9).astype(np.int64)))
    assert np.abs(seconds(found) - TRUE).max() < 50e-6
    assert abs(clock.fast) < 2.0 * clock.std


@pytest.mark.parametrize("count", [0, 1, 50])
def test_too_few_samples_keep_their_stamps(count):
    recording = recorded(TRUE[:count], WANDER[:count], 1e-3)
    found, clock, notes = in_device_time(recording)
    assert np.array_equal(found.stamps, recording.stamps)
    assert (clock, notes) == (None, [])


def test_without_the_device_s_time_nothing_changes():
    recording = JointRecording("swing", "/joint_states", ("a",), np.array([EPOCH]), np.zeros((1, 1)), ())
    assert in_device_time(recording) == (recording, None, [])
