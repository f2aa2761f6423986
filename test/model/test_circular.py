# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.model import circular


@numba.njit
def sines_and_cosines(angles):
    result = np.empty((len(angles), 2))
    for i in range(len(angles)):
        result[i, 0], result[i, 1] = circular.sine_and_cosine(angles[i])
    return result


@pytest.mark.parametrize(("range_of_angles", "limit"), [(4.0, 1e-14), (1e2, 3e-14), (1e4, 3e-12), (1e6, 3e-10)])
def test_sine_and_cosine_are_right_to_the_last_digits_that_the_angle_has(range_of_angles, limit):
    angles = np.concatenate(
        [
            np.random.default_rng(1).uniform(-range_of_angles, range_of_angles, 100_000),
            np.arange(-8, 9) * (np.pi / 4),
            np.nextafter(np.pi * np.array([-3, -1, 1, 3]), 0.0),
        ]
    )
    exact = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    assert np.abs(sines_and_cosines(angles) - exact).max() < limit


@given(angle=st.floats(-1e3, 1e3))
def test_sine_and_cosine_lie_on_the_unit_circle(angle):
    assert np.hypot(*sines_and_cosines(np.array([angle]))[0]) == pytest.approx(1.0, abs=1e-14)
