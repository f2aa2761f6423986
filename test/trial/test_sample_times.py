# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The times of samples are those in which the motion is smooth, stamps or times of receipt, or the device's own."""

import re
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.bag.device_messages import ClockRate
from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.sample_times import in_device_time, in_measured_time

TIME = np.arange(2000) * 0.005
NOISE = np.random.default_rng(1).normal(0.0, 2e-4, (2000, 2))
SWING = np.column_stack([np.sin(5 * TIME), 2 * np.cos(7 * TIME)]) + NOISE
STAMPS = 1_700_000_000_200_000_000 + 5_000_000 * np.arange(2000)
RECEIPTS = STAMPS + 300_000 + np.random.default_rng(1).integers(0, 200_000, 2000)
EPOCH = 1_700_000_000_000_000_000
TRUE = np.arange(2600) * 0.005
WANDER = 20e-6 * np.sin(TRUE / 2.0)


def recorded(stamps, receipts=RECEIPTS, angles=SWING):
    return JointRecording("", "/joint_states", ("inner_joint", "outer_joint"), stamps, angles, (), receipts=receipts)


@pytest.mark.parametrize(
    ("stamps", "fault"),
    [
        (STAMPS // 10**9 * 10**9, "are whole seconds"),
        (STAMPS // 10**9 * 10**9 + STAMPS % 10**9 // 1000, "hold microseconds where nanoseconds belong"),
        (STAMPS // 10**9 * 10**9 + STAMPS % 10**9 // 10**6, "hold milliseconds where nanoseconds belong"),
        (np.full(2000, STAMPS[0]), "are not the times of the samples"),
        ((np.float32((STAMPS - STAMPS[0]) / 1e9 + 1e5).astype(float) * 1e9).astype(np.int64), "are not the times"),
        (np.zeros(2000, dtype=np.int64), "are missing"),
        (STAMPS[0] + 1000 * (STAMPS - STAMPS[0]), "are 5 s apart, which is too long for a swing"),
        (STAMPS[0] + (STAMPS - STAMPS[0]) // 10**6, "are 5e-09 s apart, which is too short for a swing"),
    ],
)
def test_useless_stamps_give_way_to_the_times_of_receipt_unless_they_are_asked_for(stamps, fault):
    found = in_measured_time(recorded(stamps), TrialOptions())
    assert np.array_equal(found.stamps, RECEIPTS)
    assert f"the stamps {fault}" in found.notes[0]
    if np.any(stamps):
        assert np.array_equal(in_measured_time(recorded(stamps), TrialOptions(time="stamps")).stamps, stamps)


@pytest.mark.parametrize(
    ("stamps", "receipts"),
    [
        (STAMPS, RECEIPTS),
        (STAMPS, STAMPS // 50_000_000 * 50_000_000),
        (STAMPS + np.where(np.arange(2000) < 900, 10**11, 0), RECEIPTS),
        (STAMPS + np.random.default_rng(3).integers(0, 2_000_000, 2000), STAMPS[0] + np.arange(2000)),
        (STAMPS, np.full(2000, STAMPS[0])),
    ],
    ids=["good", "received in batches", "clock set back", "copied at once", "no receipt"],
)
def test_good_stamps_are_used_whatever_the_times_of_receipt_are(stamps, receipts):
    found = in_measured_time(recorded(stamps, receipts), TrialOptions())
    assert np.array_equal(found.stamps, stamps)
    assert found.notes == ()
    assert np.array_equal(in_measured_time(recorded(stamps, receipts), TrialOptions(time="receipt")).stamps, receipts)


def test_it_is_said_where_stamps_go_evenly_at_another_pace():
    found = in_measured_time(recorded(STAMPS[0] + 2 * (STAMPS - STAMPS[0])), TrialOptions())
    assert found.notes[0].startswith("samples are 10 ms by stamps but 5 ms by receipt apart")


def test_right_stamps_in_another_order_are_kept():
    order = np.random.default_rng(2).permutation(2000)
    found = in_measured_time(recorded(STAMPS[order], angles=SWING[order]), TrialOptions())
    assert np.array_equal(found.stamps, STAMPS[order])


def test_few_messages_without_stamp_are_dropped_and_counted():
    found = in_measured_time(recorded(np.where(np.isin(np.arange(2000), [3, 9]), 0, STAMPS)), TrialOptions())
    assert np.array_equal(found.stamps, np.delete(STAMPS, [3, 9]))
    assert "2 messages without a stamp are dropped" in found.notes
    assert in_measured_time(replace(found, receipts=None), TrialOptions(time="receipt")).stamps is found.stamps


def by_device(true, wander, fast=0.0, told=None, device=None):
    """Return a recording at true times [s] with stamps that wander [s], of a device whose clock is fast."""
    stamps = EPOCH + np.round((true + wander) * 1e9).astype(np.int64)
    times = np.round(true * (1.0 + fast) * 1e6).astype(np.int64) * 1000 if device is None else device
    positions = np.zeros((len(true), 2))
    return JointRecording("swing", "/joint_states", ("a", "b"), stamps, positions, (), times, told)


def seconds(recording):
    return (recording.stamps - EPOCH) * 1e-9


def test_samples_are_as_even_as_the_device_s_clock_in_seconds_by_the_rate_that_is_told():
    told = ClockRate(1e-4, 1e-6)
    found = in_device_time(by_device(TRUE, WANDER, 1e-4, told))
    assert found.device_rate is told
    assert np.ptp(seconds(found) - TRUE) < 2e-6  # the device's microseconds
    assert abs(np.mean(seconds(found) - TRUE)) < 20e-6
    assert re.search("100 ± 1 ppm fast.* us rms", *found.notes)


def test_untold_the_rate_is_that_of_the_stamps_and_as_uncertain_as_they_wander():
    found = in_device_time(by_device(TRUE, WANDER, -5e-3))
    clock = found.device_rate
    assert abs(clock.fast + 5e-3) < 2.0 * clock.std
    assert 1e-6 < clock.std < 2e-5
    assert np.ptp(seconds(found) - TRUE) < 13.0 * 2.0 * clock.std


def test_a_reset_of_the_device_begins_another_run_and_no_sample_moves_by_it():
    times = np.where(TRUE < 5.0, TRUE + 100.0, TRUE - 5.0)
    found = in_device_time(by_device(TRUE, WANDER, device=np.round(times * 1e9).astype(np.int64)))
    assert np.abs(seconds(found) - TRUE).max() < 50e-6
    assert abs(found.device_rate.fast) < 2.0 * found.device_rate.std


@pytest.mark.parametrize("count", [0, 1, 50])
def test_too_few_samples_keep_their_stamps(count):
    recording = by_device(TRUE[:count], WANDER[:count], 1e-3, ClockRate(1e-3, 1e-6))
    found = in_device_time(recording)
    assert np.array_equal(found.stamps, recording.stamps)
    assert (found.device_rate, found.notes) == (None, ())


def test_without_the_device_s_time_nothing_changes():
    recording = JointRecording("swing", "/joint_states", ("a",), np.array([EPOCH]), np.zeros((1, 1)), ())
    assert in_device_time(recording) == recording


@pytest.mark.parametrize("jitter", [0.2e-3, 1e-3])
def test_the_jitter_of_the_times_of_receipt_is_said(jitter):
    late = np.random.default_rng(3).exponential(jitter, len(RECEIPTS))
    found = in_measured_time(
        recorded(RECEIPTS, np.sort(RECEIPTS + (late * 1e9).astype(np.int64))), TrialOptions(time="receipt")
    )
    assert float(found.notes[-1].split()[-2]) == pytest.approx(1e3 * jitter, rel=0.25)
