# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import TrialError
from cdp_ident.trial.kinematics import encoder_step, fourth_differences, local_motion
from scenarios.twin import as_measured, standard_motion


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(6, 200))
def test_a_cubic_motion_is_recovered_exactly_whatever_the_spacing_of_its_samples(seed, count):
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.002, 0.01, count))
    coefficients = rng.normal(size=(4, 2))
    motion = np.polynomial.Polynomial
    theta = np.stack([motion(coefficients[:, k])(time) for k in range(2)], axis=1)
    at = np.linspace(time[0], time[-1], 7)
    angles, velocities = local_motion(time, theta, at)
    for k in range(2):
        np.testing.assert_allclose(angles[:, k], motion(coefficients[:, k])(at), atol=1e-9)
        np.testing.assert_allclose(velocities[:, k], motion(coefficients[:, k]).deriv()(at), atol=1e-6)


def test_noise_of_two_milliradians_at_200_hz_leaves_velocities_good_to_a_twentieth_of_a_radian_a_second():
    time = np.arange(0, 10, 0.005)
    noise = np.random.default_rng(1).normal(scale=2e-3, size=(len(time), 2))
    theta = np.sin(8 * time)[:, None] + noise
    _, velocities = local_motion(time, theta, time[20:-20])
    error = velocities - 8 * np.cos(8 * time[20:-20])[:, None]
    assert np.sqrt(np.mean(error**2)) < 0.05


def test_fewer_than_six_samples_are_refused():
    with pytest.raises(TrialError, match="only 5 samples"):
        local_motion(np.arange(5.0), np.zeros((5, 2)), np.array([0.0]))


def measured(noise, counts_per_turn=None):
    return as_measured(standard_motion(), np.random.default_rng(0), noise, counts_per_turn)


def test_fourth_differences_show_white_noise_as_it_is_and_nothing_of_a_cubic_at_uneven_times():
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.002, 0.008, 4000))
    cubic = np.column_stack([time**3, 5.0 - time**2])
    assert np.abs(fourth_differences(time, cubic)).max() < 1e-9
    noise = rng.normal(0, 1e-3, cubic.shape)
    assert fourth_differences(time, cubic + noise).std(axis=0) == pytest.approx([1e-3, 1e-3], rel=0.05)
    assert fourth_differences(time, noise[:, 0]) == pytest.approx(fourth_differences(time, noise)[:, 0])


@pytest.mark.parametrize("counts", [500, 4096, 8000])
def test_the_step_of_an_encoder_is_seen(counts):
    found = encoder_step(measured(2e-4, counts)[:, 0])
    assert found == pytest.approx(2 * np.pi / counts, rel=1e-6)


def test_angles_without_steps_have_none():
    assert encoder_step(measured(2e-3)[:, 0]) == 0.0
    assert encoder_step(np.full(100, 0.3)) == 0.0
