"""Samples that arrive in bursts were measured evenly, if the motion says so."""

import numpy as np
import pytest

from cdp_ident.trial.even_times import evened

TRUE = np.arange(2000) * 0.005
NONE = np.empty(0, dtype=np.int64)
NOISE = np.random.default_rng(1).normal(0.0, 2e-4, (2000, 2))
SWING = np.column_stack([np.sin(5 * TRUE), 2 * np.cos(7 * TRUE)]) + NOISE


def arrivals(every, apart):
    """When samples come through a buffer that is emptied so often [s], one after the other."""
    emptied = np.ceil((TRUE + 1e-9) / every) * every
    place = np.arange(2000) - np.searchsorted(emptied, emptied)
    return emptied + apart * place


@pytest.mark.parametrize("apart", [0.0, 50e-6, 150e-6])
@pytest.mark.parametrize("every", [0.010, 0.016, 0.050])
def test_times_of_bursts_are_those_of_the_samples(every, apart):
    times, (note,) = evened(arrivals(every, apart), SWING, NONE)
    assert times - times.mean() == pytest.approx(TRUE - TRUE.mean(), abs=2e-4)
    assert "samples came in bursts" in note


def test_stamps_in_bursts_are_kept_where_samples_were_measured_so():
    stamps = arrivals(0.016, 150e-6)
    measured = np.column_stack([np.sin(5 * stamps), 2 * np.cos(7 * stamps)]) + NOISE
    times, notes = evened(stamps, measured, NONE)
    assert times is stamps
    assert notes == []


def test_what_is_published_twice_with_one_stamp_is_not_spread_out():
    times, angles = np.repeat(TRUE, 2), np.repeat(SWING, 2, axis=0)
    assert evened(times, angles, NONE)[0] is times


def test_jitter_gaps_and_rest_leave_times_as_they_are():
    jitter = TRUE + np.random.default_rng(2).uniform(0.0, 2e-3, 2000)
    for stamps, angles in ((jitter, SWING), (TRUE + 3.0 * (TRUE > 4.0), SWING), (arrivals(0.016, 0.0), 0.0 * SWING)):
        assert evened(stamps, angles, NONE)[0] is stamps
