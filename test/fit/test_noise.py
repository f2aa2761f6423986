# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The noise of encoders, from the measured angles alone."""

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.fit.data import noise_over_averages
from cdp_ident.fit.noise import noise_of, rounding_of_averages
from cdp_ident.fit.thinning import thinned
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5
from scenarios.twin import TEN_SECONDS, as_measured, standard_motion


def measured(noise, counts_per_turn=None, seed=0):
    theta = as_measured(standard_motion(), np.random.default_rng(seed), noise, counts_per_turn)
    return Trial("twin", TEN_SECONDS, theta)


@pytest.mark.parametrize("noise", [2e-5, 1e-3, 2e-2])
def test_white_noise_is_found(noise):
    assert noise_of(measured(noise)) == pytest.approx([noise, noise], rel=0.08)


@pytest.mark.parametrize("memory", [0.5, 0.8])
def test_noise_that_is_remembered_is_found_in_its_whole_size(memory):
    fresh = np.random.default_rng(3).normal(scale=1e-3 * np.sqrt(1 - memory**2), size=(len(TEN_SECONDS), 2))
    noise = lfilter([1.0], [1.0, -memory], fresh, axis=0)
    assert noise_of(Trial("twin", TEN_SECONDS, standard_motion() + noise)) == pytest.approx([1e-3, 1e-3], rel=0.35)


@pytest.mark.parametrize("counts", [2000, 8000])
def test_an_encoder_without_other_noise_has_that_of_its_steps(counts):
    step = 2 * np.pi / counts
    # theta2 is the sum of both encoders' angles.
    assert noise_of(measured(0.0, counts)) == pytest.approx(step / np.sqrt(12) * np.array([1, np.sqrt(2)]), rel=0.15)


@pytest.mark.parametrize("noise", [3e-4, 2e-3])
def test_noise_and_steps_add_up(noise):
    step = 2 * np.pi / 8000
    expected = np.sqrt(noise**2 + step**2 / 12 * np.array([1, 2]))
    assert noise_of(measured(noise, 8000)) == pytest.approx(expected, rel=0.15)


def test_uneven_stamps_are_no_noise():
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.002, 0.008, 1800))
    theta = simulate(physical_coefficients(TABLE_5), np.array(TABLE_3), time, step=0.001)[:, :2]
    found = noise_of(Trial("uneven", time, theta + rng.normal(0, 1e-3, theta.shape)))
    assert found == pytest.approx([1e-3, 1e-3], rel=0.08)


def test_the_noise_of_each_angle_is_its_own():
    theta = standard_motion() + np.random.default_rng(0).normal(0, [1e-3, 4e-3], (2000, 2))
    assert noise_of(Trial("twin", TEN_SECONDS, theta)) == pytest.approx([1e-3, 4e-3], rel=0.08)


def test_outliers_do_not_count():
    trial = measured(1e-3)
    theta = trial.theta.copy()
    theta[::100] += 1.0
    assert noise_of(Trial("wild", trial.time, theta)) == pytest.approx([1e-3, 1e-3], rel=0.15)


def test_an_encoder_that_hardly_moves_has_at_least_the_noise_of_its_steps():
    step = 2 * np.pi / 2000
    theta = np.round(np.column_stack([0.02 * np.sin(TEN_SECONDS)] * 2) / step) * step
    # theta2, whose encoder does not move at all, has the inner encoder's.
    assert np.all(noise_of(Trial("slow", TEN_SECONDS, theta)) >= step / np.sqrt(12) * 0.999)


@pytest.mark.parametrize("size", [0.1, 1.0])
def test_outliers_do_not_count_where_most_steps_repeat(size):
    step = 2 * np.pi / 2000
    theta = np.round(np.column_stack([0.02 * np.sin(TEN_SECONDS)] * 2) / step) * step
    theta[100::300] += size
    assert np.all(noise_of(Trial("slow", TEN_SECONDS, theta)) < 2 * step / np.sqrt(12))


@pytest.mark.parametrize("together", [2, 5])
@pytest.mark.parametrize(("speed", "share"), [(0.02, 0.9), (0.3, 0.3), (40.0, 0.0)])
def test_rounding_that_does_not_average_out_is_most_of_the_averages_error_where_a_joint_is_slow(together, speed, share):
    step, time = 2 * np.pi / 2000, np.arange(40_000) * 0.001
    inner, outer = speed * time, 0.7 * speed * time + 0.3 * speed * np.sin(time)
    true = np.column_stack([inner, inner + outer])
    read = np.column_stack([np.round(inner / step), np.round(inner / step) + np.round(outer / step)]) * step
    error = (read - true).reshape(-1, together, 2).mean(axis=1).std(axis=0)
    found = rounding_of_averages(Trial("averaged", time, read), together)
    assert np.all(found <= 1.05 * error)
    assert np.all(found >= share * error)


def test_the_rounding_of_a_joint_that_soon_stops_is_part_of_the_noise_of_averages():
    step, time = 2 * np.pi / 4000, np.arange(10_000) * 0.001
    inner, outer = 0.5 * np.sin(3.0 * np.minimum(time, 0.5)), 3.0 * np.sin(3.0 * time)
    read = np.cumsum(np.round(np.column_stack([inner, outer]) / step), axis=1) * step
    trial = Trial("stops", time, read)
    averaged = thinned(trial, 3)
    assert noise_of(averaged)[0] < 0.3 * step / np.sqrt(12), "differences do not show it"
    assert noise_over_averages([trial], [averaged], 3)[0] == pytest.approx(step / np.sqrt(12), rel=0.1)
