# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import TrialError
from cdp_ident.trial.kinematics import local_motion


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
