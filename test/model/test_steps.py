# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Steps are divided where their error would be too large, and what cannot be computed is given up."""

import numpy as np
import pytest

from cdp_ident.model.acting import NO_EFFECTS, ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.motions import InitialValueProblem, accelerations_at, motions, simulate
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.model.time_grid import TimeGrid
from reference.pendulum import TABLE_3, TABLE_5, motion

EFFECTS = {effect.key: effect for effect in CATALOGUE}
COEFFICIENTS = physical_coefficients(TABLE_5)


def rates(state):
    return np.concatenate([state[2:], accelerations_at(COEFFICIENTS, state[None], np.zeros(1))[0]])


def with_undivided_steps(start, h, count):
    states = [start]
    for _ in range(count):
        y = states[-1]
        k1 = rates(y)
        k2 = rates(y + 0.5 * h * k1)
        k3 = rates(y + 0.5 * h * k2)
        states.append(y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rates(y + h * k3)))
    return np.array(states)


@pytest.mark.parametrize(("fast", "divided"), [(0.0, False), (12.0, True)])
def test_a_step_is_divided_where_a_motion_asks_for_it(fast, divided):
    start, h = np.add(TABLE_3, [0.0, 0.0, fast, -fast]), 0.02 if divided else 0.005
    times = h * np.arange(31)
    found, undivided = simulate(COEFFICIENTS, start, times, step=h), with_undivided_steps(start, h, 30)
    if not divided:
        np.testing.assert_allclose(found, undivided, rtol=0, atol=1e-11)
    exact = motion(TABLE_5, start, times)
    assert np.abs(found - exact)[:, :2].max() < 1e-5
    assert (np.abs(undivided - exact)[:, :2].max() > 3e-5) == divided


def test_a_motion_that_becomes_infinite_within_a_step_is_given_up():
    """What moves along with the cart is lighter than the rods, which no cart is: the inertia passes through zero."""
    coefficients = np.array(
        [0.15117463568005213, 0.10626842882317278, 8.983200174583285, 0.3433203943053101, 0.025157550517132414,
         0.15117463568005213 / 1.2589742355007962, 9.81]
    )  # fmt: skip
    start = np.array(
        [3.8712500602911764, 38.01969678824838, -3.1637829162871043, -2.077637679905242, -0.017786062414330065,
         0.10021555745457902]
    )  # fmt: skip
    grid = TimeGrid.over(np.arange(79) * 0.001688120913358211, 0.001688120913358211)
    effects = [
        (EFFECTS["coulomb_friction.inner"], [0.10093879122293042]),
        (EFFECTS["pivot_compliance.base.oscillating"], [2.161700206447164e-05, 24.402744155425612, 0.0]),
    ]
    acting = ActingEffects.of(effects, 0.4, fitted=True)
    found = motions([InitialValueProblem(coefficients, start, grid, np.zeros(2 * grid.steps + 1), acting)], derive=True)
    assert np.all(np.isfinite(found.readings[:50]))
    for lost in (found.readings[-1], found.by[-1], found.ends, found.ends_by):
        assert np.all(np.isnan(lost))


@pytest.mark.parametrize("effects", [(), ((EFFECTS["coulomb_friction.outer"], [0.2]),)], ids=["alone", "with friction"])
def test_a_rod_that_no_step_resolves_is_given_up_from_there_on(effects):
    acting, grid = ActingEffects.of(effects, 0.4) if effects else NO_EFFECTS, TimeGrid.over(np.arange(200) / 200.0)
    fast, quick = (
        InitialValueProblem(COEFFICIENTS, np.array([1.0, 2.0, *speeds]), grid, np.zeros(2 * grid.steps + 1), acting)
        for speeds in ((-3e5, 1e5), (20.0, 30.0))
    )
    lost = motions([fast], derive=True)
    assert np.all(np.isnan(lost.readings))
    assert np.all(np.isnan(lost.by))
    assert np.all(np.isfinite(motions([quick]).readings))
