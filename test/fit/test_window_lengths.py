import numpy as np
import pytest

from cdp_ident.fit.scales import scales_of
from cdp_ident.fit.window_lengths import predictable_lengths, window_bounds
from cdp_ident.trial.trial import Trial
from reference.own_units import Rig

G, NOISE = 9.81, np.full(2, 1e-2)
WHIRLING = np.array([0.24, 0.3, 0.0, 0.0])
RIG = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.1, c2=0.05)


def evenly(count, breaks=()):
    time = 0.01 * np.arange(count)
    return Trial("even", time, np.zeros((count, 2)), breaks=breaks)


def test_windows_are_as_long_as_asked_where_they_begin():
    (bounds,) = window_bounds(evenly(1001), lambda time: 1.0 if time < 4.0 else 3.0)
    assert bounds == [0, 100, 200, 300, 400, 700, 1001]


def test_no_window_at_the_end_is_much_shorter_than_the_others():
    (bounds,) = window_bounds(evenly(1001), lambda time: 3.0)
    assert np.diff(bounds).tolist() == [300, 300, 200, 201]


def test_none_is_longer_than_the_longest():
    (bounds,) = window_bounds(evenly(1001), lambda time: 30.0, longest=2.5)
    assert np.diff(bounds).tolist() == [250, 250, 250, 251]


def test_no_window_goes_over_a_gap():
    assert window_bounds(evenly(700, breaks=(300, 450)), lambda time: 2.0) == [
        [0, 150, 300],
        [300, 450],
        [450, 700],
    ]


def test_a_motion_that_calms_down_is_cut_into_longer_and_longer_windows(measured, true_groups):
    groups, _ = true_groups(RIG, 0.4)
    trial = measured(rate=200.0, noise=1e-2, start=WHIRLING, units=100.0, rig=RIG)
    scales = scales_of([trial], 0.4, G, NOISE, lambda _: groups)
    length_at = predictable_lengths(trial, scales, groups, 0.4, G, NOISE)
    assert scales.shortest_piece <= length_at(0.0) < 0.6 * length_at(0.8 * trial.duration)
    assert length_at(0.8 * trial.duration) <= scales.longest_window


def test_without_groups_all_are_alike(measured):
    trial = measured()
    scales = scales_of([trial], 0.4, G, NOISE)
    length_at = predictable_lengths(trial, scales, None, 0.4, G, NOISE)
    assert length_at(0.0) == length_at(5.0) == scales.window == pytest.approx(2.5, rel=1e-3)
