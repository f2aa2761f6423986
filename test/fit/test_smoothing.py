import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.errors import TrialError
from cdp_ident.fit.smoothing import smooth
from reference.own_units import Rig, motion

RIG = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01)
START = np.array([2.0, 2.6, 0.0, 0.0])


def smoothed(rate, noise, copies=4, memory=0.0):
    rng = np.random.default_rng(2)
    time = np.arange(0.0, 40.0, 1.0 / rate)
    fresh = rng.normal(scale=noise * np.sqrt(1.0 - memory**2), size=(len(time), 2))
    samples = motion(RIG, START, time)[:, :2] + lfilter([1.0], [1.0, -memory], fresh, axis=0)
    return smooth(time, samples, 0.025, copies, rng)


@pytest.mark.parametrize(
    ("rate", "memory", "at_most"), [(10.0, 0.0, 2.0), (40.0, 0.0, 2.0), (200.0, 0.0, 2.0), (200.0, 0.8, 2.5)]
)
@pytest.mark.parametrize("noise", [1e-5, 1e-3, 1e-2])
def test_speeds_are_as_good_as_what_is_measured_again_says(rate, memory, at_most, noise):
    smooth_motion = smoothed(rate, noise, memory=memory)
    truth = motion(RIG, START, smooth_motion.time)[:, 2:]
    known = smooth_motion.known
    error = np.std((smooth_motion.rates[0] - truth)[known])
    again = np.std((smooth_motion.rates[1:] - smooth_motion.rates[0])[:, known])
    assert error < at_most * again


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 1e-2])
def test_the_noise_is_seen_in_what_is_left(noise):
    assert np.sqrt(np.diag(smoothed(40.0, noise).noise)) == pytest.approx(noise, rel=0.1)


def test_noise_that_is_remembered_is_not_taken_for_motion():
    """Cross-validation alone makes errors of 0.1 rad/s."""
    found = smoothed(200.0, 1e-3, memory=0.8)
    truth = motion(RIG, START, found.time)[:, 2:]
    assert np.std((found.rates[0] - truth)[found.known]) < 1e-2
    assert np.sqrt(np.diag(found.noise)) == pytest.approx(1e-3, rel=0.15)


def test_more_noise_takes_more_samples_to_a_knot():
    assert smoothed(100.0, 1e-2).per_knot > 2 * smoothed(100.0, 1e-5).per_knot


def test_across_a_gap_nothing_is_known():
    time = np.arange(0.0, 40.0, 0.025)
    samples = motion(RIG, START, time)[:, :2]
    kept = (time < 10.0) | (time > 12.0)
    gap = smooth(time[kept], samples[kept], 0.025, 1, np.random.default_rng(0))
    assert not np.any(gap.known[(gap.time > 10.1) & (gap.time < 11.9)])
    assert np.mean(gap.known[(gap.time > 1.0) & (gap.time < 9.5)]) == 1.0


@pytest.mark.parametrize("count", [24, 25, 30])
def test_a_few_samples_are_smoothed_and_not_passed_through(count):
    time = np.arange(count) / 40.0
    samples = motion(RIG, START, time)[:, :2] + np.random.default_rng(0).normal(scale=1e-3, size=(count, 2))
    assert np.all(np.diag(smooth(time, samples, 0.025, 1, np.random.default_rng(0)).noise) > 1e-8)


def test_too_few_samples_are_told():
    with pytest.raises(TrialError, match="only 10 samples"):
        smooth(np.arange(10.0), np.zeros((10, 2)), 0.1, 1, np.random.default_rng(0))
