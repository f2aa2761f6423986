# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's equations of motion, as they are printed and as they are mended."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.model.formulas.language import ACCELERATIONS, COEFFICIENTS, DERIVED, PAPER, STATE
from cdp_ident.model.formulas.syntax import evaluated
from cdp_ident.model.parameters import SYMBOLS, physical_coefficients
from reference import pendulum
from reference.pendulum import TABLE_2
from reference.strategies import pendulums, starts


@given(values=pendulums(), state=starts(speed=30.0), u=st.floats(-20, 20))
def test_the_accelerations_of_the_lagrangian_leave_nothing_of_the_formulas(values, state, u):
    alphas = pendulum.accelerations(values, state, u)
    named = dict(zip((*STATE, *ACCELERATIONS), (*state, *alphas, u), strict=True))
    named |= dict(zip(COEFFICIENTS, physical_coefficients(values), strict=True))
    named["m2_l2"] = evaluated(DERIVED["m2_l2"], named)
    left = [evaluated(formula, named) for formula in PAPER]
    assert left == pytest.approx([0.0, 0.0], abs=1e-9 * np.abs([*alphas, 1.0]).max())


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
def test_equation_1_is_that_of_the_lagrangian_with_its_c32_mended(values, state):
    expected = pendulum.accelerations(values, state, 0.0)
    assert accelerations_by_equation_1(values, state, state[2]) == pytest.approx(expected, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize(("c32_speed", "kept"), [(2, True), (3, False)], ids=["mended", "printed"])
def test_energy_is_kept_by_equation_1_only_with_its_c32_mended(c32_speed, kept):
    values, state = TABLE_2 | {"c1": 0.0, "c2": 0.0}, np.array([2.0, 0.5, 3.0, -4.0])
    rates = np.concatenate([state[2:], accelerations_by_equation_1(values, state, state[c32_speed])])
    power = np.ptp(pendulum.energy(values, np.array([state - 1e-6 * rates, state + 1e-6 * rates]))) / 2e-6
    assert power < 1e-6 if kept else power > 0.1
