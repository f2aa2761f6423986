# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Spikes are left out, whatever is around them; what a mechanism or an encoder does is none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.trial.outliers import TURN, outlier_words, outliers, steps

TIME = np.arange(2000) / 200.0
NOISE = 2e-3
COUNT = TURN / 8000


def whirl(rate=200.0, seconds=10.0):
    """The outer joint of rods that turn over, at up to 30 rad/s."""
    time = np.arange(round(rate * seconds)) / rate
    coefficients = physical_coefficients({**NOMINAL, "c1": 0.002, "c2": 5e-4})
    states = simulate(coefficients, np.array([0.5, 1.0, 12.0, -20.0]), time, step=0.001)
    return time, states[:, 1] - states[:, 0], states[:, 3] - states[:, 2]


OUTER = whirl()[1]


def measured(seed=0, noise=NOISE, count=COUNT, angles=OUTER):
    angles = angles + np.random.default_rng(seed).normal(0, noise, len(angles))
    return np.round(angles / count) * count if count else angles


def found(angles, time=TIME):
    return np.flatnonzero(outliers(time, angles, TURN)).tolist()


@pytest.mark.parametrize("rate", [50.0, 100.0, 200.0, 1000.0])
@pytest.mark.parametrize(("noise", "count"), [(0.0, 0.0), (2e-4, COUNT), (2e-3, COUNT), (1e-4, TURN / 2000)])
def test_a_motion_however_fast_and_coarsely_measured_has_none(rate, noise, count):
    time, angles, rates = whirl(rate)
    assert np.abs(rates).max() > 25.0
    assert found(np.mod(measured(1, noise, count, angles), TURN), time) == []


@given(st.integers(20, 1980), st.floats(-20, 20), st.floats(0, 1), st.sampled_from([0.0, 2e-4, 2e-3]))
def test_an_impulse_is_none_wherever_it_falls_between_samples(at, change, between, noise):
    kink = change * np.maximum(TIME - TIME[at] + between * 0.005, 0.0)
    assert found(measured(at, noise, angles=OUTER + kink)) == []


@given(st.integers(20, 1980), st.integers(-2000, 2000))
def test_lost_counts_are_none(at, counts):
    assert found(measured(at, 2e-4, angles=OUTER + np.where(TIME[at] <= TIME, counts * COUNT, 0.0))) == []


def test_a_joint_that_stops_and_rests_on_the_edge_of_a_count_has_none():
    stops = np.where(TIME < 5.0, 3.0 * (TIME - 5.0) * np.abs(TIME - 5.0), 0.0) + 0.5 * COUNT
    assert found(measured(3, 0.05 * COUNT, angles=stops)) == []
    assert found(measured(3, 0.3 * COUNT, angles=stops)) == []


@given(
    st.lists(st.integers(0, 1999), min_size=1, max_size=5),
    st.integers(1, 3),
    st.floats(0.5, np.pi),
    st.sampled_from([-1.0, 1.0]),
    st.booleans(),
)
def test_spikes_are_found_anywhere_alone_or_in_a_row_wrapped_or_not(places, row, size, sign, wrapped):
    angles = measured(len(places))
    apart = [at for k, at in enumerate(sorted(places)) if k == 0 or at - sorted(places)[k - 1] > 20]
    spikes = sorted({min(at + k, 1999) for at in apart for k in range(row)})
    angles[spikes] += sign * size
    assert found(np.mod(angles, TURN) if wrapped else angles) == spikes


@given(st.data())
def test_spikes_near_one_another_or_beside_lost_samples_are_found_together(data):
    at = data.draw(st.integers(50, 1900))
    spikes = sorted(data.draw(st.sets(st.integers(at, at + 6), min_size=1, max_size=3)))
    lost = data.draw(st.sets(st.integers(at - 12, at + 18), max_size=4)) - set(spikes)
    angles = measured(at)
    angles[spikes] += data.draw(st.floats(0.3, 3.0))
    kept = np.setdiff1d(np.arange(2000), list(lost))
    assert kept[found(angles[kept], TIME[kept])].tolist() == spikes


@pytest.mark.parametrize("seed", range(3))
def test_of_one_in_a_hundred_hardly_any_is_missed_and_nothing_else_is_left_out(seed):
    rng = np.random.default_rng(seed)
    spikes = rng.choice(2000, 20, replace=False)
    sizes = rng.uniform(-1, 1, 20)
    angles = measured(seed)
    angles[spikes] += sizes
    left_out = found(angles)
    assert set(left_out) <= set(spikes)
    missed = np.abs(sizes[~np.isin(spikes, left_out)])
    assert np.all(missed < 12 * NOISE)


def test_a_spike_small_against_the_swing_but_large_against_the_noise_is_found():
    angles = measured(4)
    angles[[300, 900, 1500]] += 14 * NOISE
    assert found(angles) == [300, 900, 1500]


def test_beside_a_long_gap_and_where_the_clock_was_set_back_spikes_are_found_all_the_same():
    kept = np.r_[0:1000, 1020:2000]
    angles = measured(5)
    angles[[998, 1021]] += 1.0
    assert kept[found(angles[kept], TIME[kept])].tolist() == [998, 1021]
    set_back = np.where(TIME < 5.0, TIME, TIME - 1.0)
    assert found(angles, set_back) == [998, 1021]


def test_a_position_that_is_no_angle_may_be_wild_by_a_turn():
    position = np.random.default_rng(6).normal(0, 1e-4, 2000)
    position[700] += TURN
    assert np.flatnonzero(outliers(TIME, position)).tolist() == [700]
    assert found(position) == []


@given(st.lists(st.floats(-1e6, 1e6), max_size=60))
def test_whatever_the_numbers_and_however_few_an_answer_comes(values):
    mask = outliers(TIME[: len(values)], np.array(values), TURN)
    assert mask.shape == (len(values),)


def test_how_many_and_where_is_said_in_words():
    assert outlier_words([3.412, *range(4, 15)], 1988) == "12 outliers (0.6 %) are left out, the first at 3.412 s"
    assert outlier_words([0.5], 999) == "1 outlier (0.1 %) is left out, at 0.500 s"


@pytest.mark.parametrize("kink", [0.5, 5.0, 20.0])
def test_a_step_that_stays_is_told_from_an_impulse_and_from_a_spike(kink):
    knocked = measured(noise=2e-4, angles=OUTER + kink * np.maximum(0.0, TIME - 5.002))
    assert not np.any(steps(TIME, knocked))
    stepped = knocked + 0.1 * (TIME >= 3.0)
    assert np.flatnonzero(steps(TIME, stepped)).tolist() == [600]
    assert np.sum(steps(TIME, stepped)) == pytest.approx(0.1, abs=3e-3)
