# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's equations of motion, as they are printed and as they are mended."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cdp_ident.model.formulas.language import ACCELERATIONS, COEFFICIENTS, DERIVED, PAPER, STATE
from cdp_ident.model.formulas.syntax import evaluated
from cdp_ident.model.parameters import SYMBOLS, physical_coefficients
from reference import pendulum
from reference.pendulum import TABLE_2, TABLE_3
from reference.strategies import pendulums, starts


@given(values=pendulums(), state=starts(speed=30.0), u=st.floats(-20, 20))
def test_the_accelerations_of_the_lagrangian_leave_nothing_of_the_formulas(values, state, u):
    alphas = pendulum.accelerations(values, state, u)
    named = dict(zip((*STATE, *ACCELERATIONS), (*state, *alphas, u), strict=True))
    named |= dict(zip(COEFFICIENTS, physical_coefficients(values), strict=True))
    named["m2_l2"] = evaluated(DERIVED["m2_l2"], named)
    left = [evaluated(formula, named) for formula in PAPER]
    assert left == pytest.approx([0.0, 0.0], abs=1e-9 * np.abs([*alphas, 1.0]).max())


def motion_by_equation_1(values, times, c32_speed):
    """Return the states (n, 4) by the paper's Eq. (1), entry by entry; C32 contains the speed number `c32_speed`."""
    m1, m2, m0, l1, l2, J1, J2, c1, c2, L, g = (values[symbol] for symbol in (*SYMBOLS, "L", "g"))

    def derivative(_, state):
        theta, speeds = state[:2], state[2:]
        s, c = np.sin(theta[0] - theta[1]), np.cos(theta[0] - theta[1])
        A = np.array([[m1 * l1**2 + J1 + (m2 + m0) * L**2, m2 * L * l2 * c], [m2 * L * l2 * c, m2 * l2**2 + J2]])
        C = np.array([[c1 + c2, m2 * L * l2 * speeds[1] * s - c2], [-m2 * L * l2 * speeds[c32_speed] * s - c2, c2]])
        gravity = np.array([(m1 * l1 + (m2 + m0) * L) * g, m2 * g * l2]) * np.sin(theta)
        return np.concatenate([speeds, np.linalg.solve(A, gravity - C @ speeds)])

    solution = solve_ivp(derivative, (0, times[-1]), TABLE_3, method="DOP853", t_eval=times, rtol=1e-11, atol=1e-11)
    return solution.y.T


THETA1_SPEED, THETA2_SPEED = 0, 1
WITHOUT_FRICTION = TABLE_2 | {"c1": 0.0, "c2": 0.0}


@pytest.mark.parametrize(
    ("c32_speed", "kept"), [(THETA1_SPEED, True), (THETA2_SPEED, False)], ids=["mended", "printed"]
)
def test_energy_is_kept_by_equation_1_only_with_its_c32_mended(c32_speed, kept):
    energy = pendulum.energy(
        WITHOUT_FRICTION, motion_by_equation_1(WITHOUT_FRICTION, np.linspace(0, 2, 201), c32_speed)
    )
    change = np.ptp(energy) / np.ptp(pendulum.energy(WITHOUT_FRICTION, np.array([[0, 0, 0, 0], [np.pi, np.pi, 0, 0]])))
    assert change < 1e-9 if kept else change > 0.1


def test_the_mended_equation_1_is_the_equation_of_the_lagrangian():
    times = np.linspace(0, 3, 301)
    expected = pendulum.motion(TABLE_2, TABLE_3, times)
    np.testing.assert_allclose(motion_by_equation_1(TABLE_2, times, THETA1_SPEED), expected, atol=1e-7)
