# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials cut into windows."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.fit.windows import cut_into_windows, share_of
from cdp_ident.model.motions import simulate
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3
from scenarios.twin import standard_twin

TWIN = standard_twin(np.random.default_rng(0))


def uneven(seconds, seed=0):
    time = np.cumsum(np.random.default_rng(seed).uniform(0.001, 0.01, round(seconds / 0.0055)))
    return Trial("uneven", time - time[0], np.column_stack([np.sin(time), np.cos(time)]))


@given(seconds=st.floats(1.0, 20.0), duration=st.floats(0.5, 30.0), seed=st.integers(0, 9))
def test_windows_hold_every_sample_once_and_are_about_as_long_as_asked(seconds, duration, seed):
    trial = uneven(seconds, seed)
    windows = cut_into_windows([trial], duration)
    assert np.array_equal(np.concatenate([window.theta for window in windows]), trial.theta)
    assert [window.samples.start for window in windows] == [0, *(window.samples.stop for window in windows[:-1])]
    length = trial.duration / len(windows)
    assert all(abs(window.duration - length) < 0.03 for window in windows)
    assert len(windows) == max(1, round(trial.duration / duration))


def test_windows_know_their_trial_and_when_they_begin_and_one_of_any_length_is_the_whole_trial():
    windows = cut_into_windows([TWIN, TWIN])
    assert [(window.trial, window.begin) for window in windows] == [(k, 2.5 * n) for k in (0, 1) for n in range(4)]
    (whole,) = cut_into_windows([TWIN], np.inf)
    assert np.array_equal(whole.theta, TWIN.theta)
    assert np.array_equal(whole.time, TWIN.time)


def test_a_window_with_too_few_samples_is_left_out():
    time = np.concatenate([np.arange(500) / 200, 3.0 + np.arange(5) / 2])
    trial = Trial("gap", time, np.zeros((505, 2)))
    assert [window.begin for window in cut_into_windows([trial])] == [0.0]


def test_a_start_is_estimated_near_the_true_one_from_its_own_window_alone():
    assert np.abs(cut_into_windows([TWIN])[0].start - TABLE_3).max() < 0.3
    theta = TWIN.theta.copy()
    theta[500:1000] = 1e3
    for before, after in zip(cut_into_windows([TWIN]), cut_into_windows([replace(TWIN, theta=theta)]), strict=True):
        assert np.array_equal(before.start, after.start) == (before.begin != 2.5)


@pytest.mark.parametrize("cart", [None, np.full(2000, 0.2)])
def test_a_cart_that_rests_has_no_acceleration(cart):
    trial = replace(TWIN, cart=cart)
    assert trial.cart_acceleration is None
    assert not np.any(cut_into_windows([trial])[0].u)


@pytest.fixture(scope="module")
def driven():
    """The twin over a moving cart."""
    return replace(TWIN, cart=0.1 * np.sin(3 * TWIN.time))


def test_every_window_of_a_moving_cart_has_its_stretch_of_the_acceleration(driven):
    for window in cut_into_windows([driven]):
        expected = -0.9 * np.sin(3 * (window.begin + window.grid.half_step_times()))
        # A natural spline is straight at the ends of the trial.
        assert np.abs(window.u - expected)[100:-100].max() < 0.01


def test_pieces_of_a_window_have_their_stretch_of_what_it_has(driven):
    (window,) = cut_into_windows([driven], np.inf)
    pieces, whole = window.in_pieces(150), window.in_pieces()
    assert whole.steps_at.tolist() == [0, window.grid.steps]
    assert np.array_equal(whole.place, window.grid.place)
    assert pieces.steps_at[[0, 1, -1]].tolist() == [0, 150, window.grid.steps]
    assert pieces.samples_at[[0, -1]].tolist() == [0, len(window.theta)]
    for k, begin in enumerate(pieces.begin):
        steps, samples = (slice(*of[k : k + 2]) for of in (pieces.steps_at, pieces.samples_at))
        halves = begin + 0.5 * pieces.step[k] * np.arange(2 * (steps.stop - steps.start) + 1)
        u = pieces.u[2 * steps.start + k : 2 * steps.stop + k + 1]
        assert u == pytest.approx(np.interp(halves, window.grid.half_step_times(), window.u), abs=1e-9)
        assert begin + pieces.step[k] * pieces.place[samples] == pytest.approx(TWIN.time[samples])
        assert window.states(begin[None])[0, :2] == pytest.approx(TWIN.theta[samples][0], abs=0.05)


def test_the_grid_simulates_up_to_the_window_s_last_sample():
    (window,) = cut_into_windows([uneven(3.0)], np.inf)
    states = simulate(np.array([0.3, 0.3, 2.0, 0.0, 0.0, 0.8, 9.81]), np.array([3.0, 3.0, 0.0, 0.0]), window.time)
    assert len(states) == len(window.theta)
    assert window.grid.half_step_times()[-1] >= window.time[-1] - 1e-9


TRIALS, WINDOWS, WINDOW = 60, 34, 1.0


@pytest.fixture(scope="module")
def windows():
    time = np.arange(round(20 * WINDOWS * WINDOW) + 1) / 20.0
    trial = Trial("swing", time, np.column_stack([np.sin(time), np.cos(time)]))
    return cut_into_windows([trial] * TRIALS, WINDOW)


def test_all_are_taken_where_there_is_no_more_motion_than_enough(windows):
    few = [window.duration for window in windows[:10]]
    assert share_of(few, sum(few)) == tuple(range(10))
    assert share_of(few, np.inf) == tuple(range(10))


@pytest.mark.parametrize("enough", [60.0, 200.0])
def test_a_share_holds_as_much_motion_as_was_asked_for(windows, enough):
    chosen = share_of([window.duration for window in windows], enough)
    assert sum(windows[index].duration for index in chosen) == pytest.approx(enough, abs=2 * WINDOW)
    assert list(chosen) == sorted(set(chosen))


def test_every_trial_and_every_part_of_a_trial_has_its_share(windows):
    chosen = share_of([window.duration for window in windows], 200.0)
    of_trial = np.bincount([windows[index].trial for index in chosen], minlength=TRIALS)
    assert of_trial.min() >= 2
    assert of_trial.max() <= 5
    of_part = np.bincount([int(4 * (index % WINDOWS) / WINDOWS) for index in chosen], minlength=4)
    assert of_part.min() > 0.7 * of_part.mean()


def test_at_least_one_is_taken():
    assert len(share_of([1.0] * 10, 0.1)) == 1
