# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Samples that came in bursts have the times in which their motion is smooth."""

import numpy as np
import pytest

from cdp_ident.errors import TrialError
from cdp_ident.trial.bursts import GAP, evened
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.recorded_motion import recorded_motion

TRUE = np.arange(2000) * 0.005
NONE = np.empty(0, dtype=np.int64)
NOISE = np.random.default_rng(1).normal(0.0, 2e-4, (2000, 2))
SWING = np.column_stack([np.sin(5 * TRUE), 2 * np.cos(7 * TRUE)]) + NOISE
STAMPS = 1_700_000_000_200_000_000 + 5_000_000 * np.arange(2000)


def arrivals(every, apart, jitter=0.0):
    """When samples come through a buffer that is emptied so often [s], one after the other."""
    turn = np.ceil((TRUE + 1e-9) / every).astype(int)
    emptied = turn * every + np.random.default_rng(4).uniform(0.0, jitter, turn[-1] + 1)[turn]
    place = np.arange(2000) - np.searchsorted(turn, turn)
    return emptied + apart * place


@pytest.mark.parametrize("apart", [0.0, 50e-6, 150e-6])
@pytest.mark.parametrize("every", [0.010, 0.016, 0.050])
def test_times_of_bursts_are_those_of_the_samples(every, apart):
    times, (note,), _ = evened(arrivals(every, apart), SWING, NONE, GAP)
    assert times - times.mean() == pytest.approx(TRUE - TRUE.mean(), abs=2e-4)
    assert "samples came in bursts" in note


@pytest.mark.parametrize("every", [0.016, 0.050])
@pytest.mark.parametrize("jitter", [0.0, 2e-3])
def test_samples_that_were_lost_within_bursts_leave_gaps(every, jitter):
    kept = np.random.default_rng(5).random(2000) > 0.01
    times, (note,), _ = evened(arrivals(every, 100e-6, jitter)[kept], SWING[kept], NONE, GAP)
    off = times - TRUE[kept]
    assert off - np.median(off) == pytest.approx(np.zeros(len(off)), abs=5e-4)
    assert f"{np.count_nonzero(~kept)} are missing among them" in note


def test_how_sure_the_pace_of_bursts_is_goes_with_its_error():
    paces = [evened(arrivals(0.016, 1e-4, jitter), SWING, NONE, GAP) for jitter in np.linspace(0.0, 2e-3, 9)]
    off = [(np.polyfit(TRUE, times, 1)[0] - 1.0) / std for times, _, std in paces]
    assert np.max(np.abs(off)) < 3.0
    assert max(std for *_, std in paces) < 1e-4


def test_whole_seconds_are_made_even():
    times, (note,), _ = evened(np.floor(TRUE + 0.4), SWING, NONE, GAP)
    assert times - times.mean() == pytest.approx(TRUE - TRUE.mean(), abs=1e-3)
    assert "every 1e+03 ms" in note


def test_a_sample_lost_in_slow_motion_shows_in_all_later_bursts():
    slow = (SWING - NOISE) * (1.0 - np.exp(-(((TRUE - 3.0) / 0.5) ** 4)))[:, None] + NOISE
    kept = np.arange(2000) != 600
    times, (note,), _ = evened(arrivals(0.016, 1e-4)[kept], slow[kept], NONE, GAP)
    assert np.ptp((times - TRUE[kept])[abs(TRUE[kept] - 3.0) > 0.5]) < 1e-3
    assert "1 are missing among them" in note


def test_no_sample_is_missed_where_the_rods_are_knocked():
    knocked = SWING + np.cumsum(np.random.default_rng(2).normal(0.0, 0.3, (5, 2)), axis=0)[TRUE.astype(int) // 2]
    times, *_ = evened(arrivals(0.016, 0.0), knocked, NONE, GAP)
    assert times - times.mean() == pytest.approx(TRUE - TRUE.mean(), abs=5e-4)


def test_stamps_in_bursts_are_kept_where_samples_were_measured_so():
    stamps = arrivals(0.016, 150e-6)
    measured = np.column_stack([np.sin(5 * stamps), 2 * np.cos(7 * stamps)]) + NOISE
    times, notes, _ = evened(stamps, measured, NONE, GAP)
    assert times is stamps
    assert notes == []


def test_what_is_published_twice_with_one_stamp_is_not_spread_out():
    times, angles = np.repeat(TRUE, 2), np.repeat(SWING, 2, axis=0)
    assert evened(times, angles, NONE, GAP)[0] is times


@pytest.mark.parametrize("most", [1e-3, 2e-3, 4e-3])
def test_times_that_jitter_about_even_ones_are_made_even_where_samples_were_measured_so(most):
    jitter = TRUE + np.random.default_rng(2).uniform(0.0, most, 2000)
    times, (note,), _ = evened(jitter, SWING, NONE, GAP)
    assert times - times.mean() == pytest.approx(TRUE - TRUE.mean(), abs=1e-4)
    assert "the times of samples jitter: they are taken 5 ms apart" in note
    measured = np.column_stack([np.sin(5 * jitter), 2 * np.cos(7 * jitter)]) + NOISE
    assert evened(jitter, measured, NONE, GAP)[0] is jitter


def test_gaps_and_rest_leave_times_as_they_are():
    for stamps, angles in ((TRUE + 3.0 * (TRUE > 4.0), SWING), (arrivals(0.016, 0.0), 0.0 * SWING)):
        assert evened(stamps, angles, NONE, GAP)[0] is stamps


@pytest.mark.filterwarnings("error")
def test_a_stretch_of_few_samples_shows_no_clock_that_is_slewed():
    some = TRUE[:31] + 5e-4 * np.sin(TRUE[:31] * 60.0)
    assert evened(some, SWING[:31], NONE, GAP)[0] is some


@pytest.mark.parametrize("together", [80, 500])
def test_bursts_too_long_to_be_followed_are_told_as_bursts(together):
    arrived = np.repeat(STAMPS[together - 1 :: together], together)
    stamps = arrived + np.arange(len(arrived)) % together * 10_000
    with pytest.raises(TrialError, match="nothing swings so fast: are they stamped in bursts"):
        recorded_motion(Samples(stamps, SWING[: len(arrived)], None), TrialOptions())
