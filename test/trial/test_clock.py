# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clock that steps, or shows milliseconds, and what are no steps of a clock."""

import numpy as np
import pytest

from cdp_ident.trial.clock import measured_times

EVEN = np.arange(2000) * 0.00499998
NONE = np.empty(0, dtype=np.int64)


def swing(time):
    """Both joints' angles, as encoders of 8000 counts read them."""
    angles = np.column_stack([np.sin(5 * time), 2 * np.cos(7 * time)])
    return np.round(angles * 4000 / np.pi) * np.pi / 4000


@pytest.mark.parametrize("size", [-0.004, -0.003, 0.001, 0.005, 0.05, 0.6, 3600.0])
def test_a_step_of_the_clock_is_said_and_taken_out(size):
    times, (note,), _ = measured_times(EVEN + size * (np.arange(2000) >= 900), swing(EVEN), NONE)
    assert times == pytest.approx(EVEN, abs=1e-7)
    assert note.startswith(f"the clock steps by {size:.3g} s at 4.495 s: taken out")


def test_where_it_steps_each_second_slow_motion_goes_with_the_rest():
    offsets = 1e-3 * np.random.default_rng(3).integers(-2, 3, 10)
    times, *_ = measured_times(EVEN + np.repeat(offsets, 200), swing(EVEN), NONE)
    assert np.ptp(times - EVEN) < 1e-7


@pytest.mark.parametrize("period", [0.0033, 0.00498, 0.0049995, 0.005003, 0.0101])
@pytest.mark.parametrize("digit", [np.floor, np.round])
def test_milliseconds_are_taken_evenly(period, digit):
    even = period * np.arange(2000) + 3.12
    kept = np.random.default_rng(2).random(2000) > 0.01
    times, (note,), _ = measured_times((1e-3 * digit(1e3 * even))[kept] - 3.12, swing(even)[kept], NONE)
    # A single slip leaves the pace unknown to a few parts in 10 000.
    assert np.polyfit(np.flatnonzero(kept), times, 1)[0] == pytest.approx(period, rel=2e-4)
    assert np.ptp(np.diff(times) / np.diff(np.flatnonzero(kept))) < 1e-9
    assert note.startswith("times are rounded to 1 ms: taken evenly")


def test_milliseconds_of_a_clock_that_was_set_are_even_behind_its_step():
    even = 0.00498 * np.arange(2000)
    times, notes, _ = measured_times(np.floor(1e3 * even + 40 * (np.arange(2000) >= 920)) / 1e3, swing(even), NONE)
    assert times - even == pytest.approx(np.full(2000, times[0]), abs=1e-3)
    assert [note[:15] for note in notes] == ["the clock steps", "times are round"]


@pytest.mark.parametrize("rate", [99.5, 100.3, 66.0])
def test_readings_that_are_published_at_another_pace_are_taken_evenly(rate):
    measured = np.arange(int(9.9 * rate)) / rate
    published = EVEN[np.ceil(measured / EVEN[1]).astype(int)]
    times, (note,), _ = measured_times(published, swing(measured), NONE)
    assert times - measured == pytest.approx(np.zeros(len(times)), abs=1.5e-3)
    assert "ms apart" in note


def test_times_stand_still_where_the_clock_was_set_back():
    part = np.arange(1000) >= 500
    even = 0.00498 * (np.arange(1000) - part)
    times, *_ = measured_times(np.floor(1e3 * even) / 1e3, swing(0.00498 * np.arange(1000)), np.array([500]))
    assert times[500] == times[499]
    assert times - even == pytest.approx(np.zeros(1000), abs=1.1e-3)


@pytest.mark.parametrize(("begins", "lasts"), [(1000, 1000), (700, 600)])
def test_a_clock_that_is_slewed_for_a_while_is_even_and_its_pace_not_sure(begins, lasts):
    slewed = EVEN + 5e-4 * np.clip(EVEN - EVEN[begins], 0.0, lasts * EVEN[1])
    times, (note,), pace_std = measured_times(slewed, swing(EVEN), NONE)
    assert np.ptp(np.diff(times)) < 1e-9
    assert abs(times[1] - times[0] - EVEN[1]) < 3.0 * pace_std * EVEN[1]
    assert pace_std < 3e-4
    assert note.startswith("the clock of the stamps runs at a changing pace")


def wandering(time):
    """A loop that sleeps for as long each time."""
    return np.cumsum(np.diff(time) + np.random.default_rng(3).normal(0.0, 2e-5, len(time) - 1))


def lost(time):
    return time[np.random.default_rng(2).random(len(time)) > 0.1]


def gap(time):
    return time[(time < 4.0) | (time > 4.0731)]


def slipped(time):
    """A loop that waits longer once, and goes on from there."""
    return np.concatenate([time[:900], time[900:] + 0.0037])


def jittering(time):
    return time + np.random.default_rng(2).normal(0.0, 3e-4, len(time))


def late(time):
    """Single samples are measured late."""
    return time + 0.002 * (np.arange(len(time)) % 50 == 0)


def begun_anew(time):
    """A sampler that is triggered now and then, and goes on from there."""
    chance = np.random.default_rng(4)
    return np.cumsum(np.diff(time) + (chance.random(len(time) - 1) < 0.005) * chance.uniform(-0.004, 0.004))


@pytest.mark.parametrize("taken", [lost, gap, slipped, jittering, late, begun_anew, wandering])
def test_true_times_stay(taken):
    times = taken(EVEN)
    found, notes, _ = measured_times(times, swing(times), NONE)
    assert np.array_equal(found, times)
    assert not notes


def test_lost_counts_and_a_knock_are_no_steps_of_the_clock():
    angles = swing(EVEN)
    angles[900:, 0] += 0.01
    angles[1400:, 1] += 0.5 * (EVEN[1400:] - EVEN[1400])
    times = EVEN + 0.0021 * (np.arange(2000) >= 900) + 0.003 * (np.arange(2000) >= 1400)
    assert np.array_equal(measured_times(times, angles, NONE)[0][:900], times[:900])
    times = np.delete(EVEN, [900, 1400])
    assert np.array_equal(measured_times(times, np.delete(angles, [900, 1400], 0), NONE)[0], times)


def test_rods_that_rest_for_most_of_the_time_show_a_step_in_their_motion():
    angles = swing(np.maximum(EVEN, 6.0))
    times = EVEN + 0.05 * (np.arange(2000) >= 1600)
    assert measured_times(times, angles, NONE)[0] == pytest.approx(EVEN, abs=1e-7)


def test_wrapped_angles_are_continuous():
    angles = np.mod(np.column_stack([6 * EVEN, 2 * np.cos(7 * EVEN)]) + np.pi, 2 * np.pi)
    times = EVEN + 0.004 * (np.arange(2000) >= 900)
    assert measured_times(times, angles, NONE)[0] == pytest.approx(EVEN, abs=1e-7)
    assert np.array_equal(measured_times(lost(EVEN), angles[np.isin(EVEN, lost(EVEN))], NONE)[0], lost(EVEN))


def test_few_samples_and_one_stamp_for_all_stay():
    for times in (EVEN[:9], np.zeros(100), np.zeros(0)):
        found, notes, _ = measured_times(times, swing(times), NONE)
        assert np.array_equal(found, times)
        assert not notes
