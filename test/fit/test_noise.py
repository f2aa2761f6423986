# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The noise of encoders, from the measured angles alone."""

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.fit.data import noise_over_averages
from cdp_ident.fit.noise import noise_of, rounding_of_averages
from cdp_ident.fit.thinning import thinned
from cdp_ident.trial.trial import Trial
from scenarios.twin import TEN_SECONDS, as_measured, standard_motion, twin


@pytest.mark.parametrize("noise", [2e-5, 1e-3, 2e-2, [1e-3, 4e-3]])
def test_white_noise_of_each_angle_is_found_and_outliers_do_not_count(noise):
    theta = standard_motion() + np.random.default_rng(0).normal(0, noise, (2000, 2))
    assert noise_of(Trial("twin", TEN_SECONDS, theta)) == pytest.approx(np.broadcast_to(noise, 2), rel=0.08)
    theta[::100] += 1.0
    assert noise_of(Trial("wild", TEN_SECONDS, theta)) == pytest.approx(np.broadcast_to(noise, 2), rel=0.15)


@pytest.mark.parametrize("memory", [0.5, 0.8])
def test_noise_that_is_remembered_is_found_in_its_whole_size(memory):
    fresh = np.random.default_rng(3).normal(scale=1e-3 * np.sqrt(1 - memory**2), size=(len(TEN_SECONDS), 2))
    noise = lfilter([1.0], [1.0, -memory], fresh, axis=0)
    assert noise_of(Trial("twin", TEN_SECONDS, standard_motion() + noise)) == pytest.approx([1e-3, 1e-3], rel=0.35)


@pytest.mark.parametrize(("noise", "counts"), [(0.0, 2000), (0.0, 8000), (3e-4, 8000), (2e-3, 8000)])
def test_noise_and_the_encoders_steps_add_up(noise, counts):
    # theta2 is the sum of both encoders' angles.
    expected = np.sqrt(noise**2 + (2 * np.pi / counts) ** 2 / 12 * np.array([1, 2]))
    theta = as_measured(standard_motion(), np.random.default_rng(0), noise, counts)
    assert noise_of(Trial("twin", TEN_SECONDS, theta)) == pytest.approx(expected, rel=0.15)


def test_uneven_stamps_are_no_noise():
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.002, 0.008, 1800))
    found = noise_of(twin(rng, times=time - time[0], noise=1e-3, counts_per_turn=None))
    assert found == pytest.approx([1e-3, 1e-3], rel=0.08)


@pytest.mark.parametrize("size", [0.0, 0.1, 1.0])
def test_an_encoder_that_hardly_moves_has_the_noise_of_its_steps_outliers_or_not(size):
    step = 2 * np.pi / 2000
    theta = np.round(np.column_stack([0.02 * np.sin(TEN_SECONDS)] * 2) / step) * step
    theta[100::300] += size
    found = noise_of(Trial("slow", TEN_SECONDS, theta)) / (step / np.sqrt(12))
    # theta2, whose encoder does not move at all, has the inner encoder's.
    assert np.all(found < 2)
    assert np.all(found >= (0.0 if size else 0.999))


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
