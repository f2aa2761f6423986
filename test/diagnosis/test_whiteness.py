# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether residuals are white, and related to nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.diagnosis.whiteness import MOST_LAGS, Whiteness
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.windows import cut_into_windows
from scenarios.next_swing import MODEL, TRUTH
from scenarios.twin import standard_twin

WINDOWS = cut_into_windows([standard_twin(np.random.default_rng(0))])
FIT = fit_initial_states(MODEL, TRUTH, WINDOWS)
LENGTHS = [len(window.time) for window in WINDOWS]


def whiteness_of(residuals, fit=FIT):
    parts = np.split(residuals, np.cumsum(LENGTHS)[:-1])
    return Whiteness.of(replace(fit, errors=tuple(parts)))


def test_the_correlations_are_those_of_their_definition():
    found = Whiteness.of(FIT)
    own, cross, size = np.zeros((MOST_LAGS + 1, 2)), np.zeros(2 * MOST_LAGS + 1), np.zeros(2)
    for residual in FIT.errors:
        size += np.sum(residual**2, axis=0)
        for i in range(len(residual)):
            for lag in range(-MOST_LAGS, MOST_LAGS + 1):
                if 0 <= i + lag < len(residual):
                    cross[lag + MOST_LAGS] += residual[i, 0] * residual[i + lag, 1]
                    if lag >= 0:
                        own[lag] += residual[i] * residual[i + lag]
    assert found.theta1.values == pytest.approx(own[:, 0] / size[0])
    assert found.theta2.values == pytest.approx(own[:, 1] / size[1])
    assert found.crosswise.values == pytest.approx(cross / np.sqrt(size[0] * size[1]))
    assert found.interval == pytest.approx(1 / 200)
    assert found.cart is None


def test_white_noise_is_beyond_its_bounds_in_about_one_of_a_hundred_cases():
    rng, alarms, crossed = np.random.default_rng(1), 0, 0
    for _ in range(300):
        found = whiteness_of(rng.normal(size=(sum(LENGTHS), 2)))
        alarms += found.theta1.related + found.theta2.related
        crossed += found.crosswise.related
    assert alarms <= 14  # of 600; more in one of a thousand cases
    assert crossed <= 9  # of 300


def test_noise_that_both_angles_share_does_not_count_as_a_relation():
    inner, outer = np.random.default_rng(2).normal(size=(2, sum(LENGTHS)))
    found = whiteness_of(np.column_stack([inner, inner + outer]))
    assert found.crosswise.values[MOST_LAGS] == pytest.approx(np.sqrt(0.5), abs=0.05)
    assert not found.crosswise.related


def test_residuals_that_are_correlated_in_time_are_not_white():
    noise = np.random.default_rng(3).normal(size=(sum(LENGTHS), 2))
    found = whiteness_of(np.column_stack([noise[:, 0], lfilter([1], [1, -0.3], noise[:, 1])]))
    assert not found.theta1.related
    assert found.theta2.related
    assert not found.white
    assert found.theta2.values[1:3] == pytest.approx([0.3, 0.09], abs=0.08)


def test_an_angle_that_follows_the_other_later_is_found_at_that_lag():
    noise = np.random.default_rng(4).normal(size=(sum(LENGTHS) + 3, 2))
    found = whiteness_of(np.column_stack([noise[3:, 0], 0.5 * noise[:-3, 0] + noise[3:, 1]]))
    assert found.crosswise.related
    assert int(np.argmax(np.abs(found.crosswise.values))) - MOST_LAGS == 3


def test_bounds_of_two_unrelated_series_that_are_both_correlated_in_time_are_wider():
    rng, crossed = np.random.default_rng(5), 0
    for _ in range(100):
        crossed += whiteness_of(lfilter([1], [1, -0.9], rng.normal(size=(sum(LENGTHS), 2)), axis=0)).crosswise.related
    assert crossed <= 5


def test_residuals_that_follow_the_cart_are_found():
    rng = np.random.default_rng(6)
    pushed = [replace(window, u=rng.normal(size=window.u.shape)) for window in WINDOWS]
    fit = replace(FIT, windows=tuple(pushed))
    noise = rng.normal(size=(sum(LENGTHS), 2))
    assert not any(of.related for of in whiteness_of(noise, fit).cart)
    u = np.concatenate([np.interp(w.time, w.grid.half_step_times(), w.u) for w in pushed])
    theta1, theta2 = whiteness_of(noise + np.outer(u, [0.0, 1.0]), fit).cart
    assert not theta1.related
    assert theta2.related
    assert int(np.argmax(np.abs(theta2.values))) == MOST_LAGS
