# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's equations of motion, as they are printed and as they are mended; test_rates.py tries the mended ones."""

import numpy as np
import pytest
from hypothesis import given

from cdp_ident.model.parameters import SYMBOLS
from reference import pendulum
from reference.pendulum import TABLE_2
from reference.strategies import pendulums, starts


def accelerations_by_equation_1(values, state, c32_speed):
    """Return the rods' accelerations by the paper's Eq. (1), entry by entry; C32 contains the speed `c32_speed`."""
    m1, m2, m0, l1, l2, J1, J2, c1, c2, L, g = (values[symbol] for symbol in (*SYMBOLS, "L", "g"))
    theta, speeds = state[:2], state[2:]
    s, c = np.sin(theta[0] - theta[1]), np.cos(theta[0] - theta[1])
    A = np.array([[m1 * l1**2 + J1 + (m2 + m0) * L**2, m2 * L * l2 * c], [m2 * L * l2 * c, m2 * l2**2 + J2]])
    C = np.array([[c1 + c2, m2 * L * l2 * speeds[1] * s - c2], [-m2 * L * l2 * c32_speed * s - c2, c2]])
    gravity = np.array([(m1 * l1 + (m2 + m0) * L) * g, m2 * g * l2]) * np.sin(theta)
    return np.linalg.solve(A, gravity - C @ speeds)


@given(values=pendulums(), state=starts())
def test_equation_1_is_that_of_the_lagrangian_once_its_c32_is_mended(values, state):
    expected = pendulum.accelerations(values, state, 0.0)
    assert accelerations_by_equation_1(values, state, state[2]) == pytest.approx(expected, rel=1e-9, abs=1e-6)


def test_as_it_is_printed_it_is_another_one():
    state = np.array([2.0, 0.5, 3.0, -4.0])
    expected = pendulum.accelerations(TABLE_2, state, 0.0)
    assert accelerations_by_equation_1(TABLE_2, state, state[3]) != pytest.approx(expected, rel=0.1)
