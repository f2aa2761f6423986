# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given
from scipy.signal import StateSpace

from cdp_ident.errors import OptionError
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.equilibria import EQUILIBRIA
from cdp_ident.model.linear import STATES, Mode, linearize, without_linear_part
from cdp_ident.model.motions import accelerations_at
from cdp_ident.model.parameters import SYMBOLS, inertia_about_cart, physical_coefficients
from reference import pendulum
from reference.pendulum import TABLE_2
from reference.strategies import pendulums
from scenarios.effects import acting

RODS = [1, 2, 4, 5]
COEFFICIENTS = physical_coefficients(TABLE_2)
A22 = float(inertia_about_cart(np.array([TABLE_2[symbol] for symbol in SYMBOLS]), TABLE_2["L"]))
equilibria = pytest.mark.parametrize("near", EQUILIBRIA.values(), ids=EQUILIBRIA)


def differences(accelerations, theta, step=1e-5):
    """Return a matrix (2, 5): symmetric differences of `accelerations(state, u)` by the rods' state and u."""
    rest = np.array([*theta, 0.0, 0.0, 0.0])
    columns = [
        np.subtract(*(accelerations((rest + sign * nudge)[:4], (rest + sign * nudge)[4]) for sign in (1, -1)))
        for nudge in step * np.eye(5)
    ]
    return np.column_stack(columns) / (2.0 * step)


@equilibria
@given(values=pendulums())
def test_it_is_the_derivative_of_the_lagrangian_s_equations(near, values):
    model = linearize(physical_coefficients(values), near)
    expected = differences(lambda state, u: np.array(pendulum.accelerations(values, state, u)), near)
    np.testing.assert_allclose(model.theta, near, atol=1e-12)
    found = np.column_stack([model.A[4:, RODS], model.B[4:]])
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())


def test_the_cart_is_a_double_integrator_of_the_input_and_scipy_takes_the_matrices():
    model = linearize(COEFFICIENTS, EQUILIBRIA["upright"])
    np.testing.assert_array_equal(model.A[:4], np.eye(len(STATES), k=3)[:4])
    np.testing.assert_array_equal(model.A[:, [0, 3]][4:], 0.0)
    np.testing.assert_array_equal(model.B[:4, 0], [0.0, 0.0, 0.0, 1.0])
    # The measured positions are its outputs.
    system = StateSpace(model.A, model.B, model.C, model.D)
    np.testing.assert_array_equal(system.C @ np.arange(6.0), [0.0, 1.0, 2.0])


def test_springs_add_their_stiffness():
    inner, outer = 3.0, 5.0
    springs = acting(("joint_spring.inner", [inner, 0.0]), ("joint_spring.outer", [outer, 0.0]))

    def accelerations(state, u):
        across = -outer * (state[1] - state[0]) * A22
        torque = (-inner * (state[0] - np.pi) * A22 - across, across)
        return np.array(pendulum.accelerations(TABLE_2, state, u, torque))

    model = linearize(COEFFICIENTS, EQUILIBRIA["hanging"], springs)
    found = np.column_stack([model.A[4:, RODS], model.B[4:]])
    np.testing.assert_allclose(found, differences(accelerations, model.theta), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("near", [EQUILIBRIA["upright"], EQUILIBRIA["hanging"]])
def test_a_base_that_is_not_level_shifts_the_equilibrium_and_nothing_of_the_rods(near):
    tilted, level = linearize(COEFFICIENTS, near, acting(("gravity_tilt.base", [0.05]))), linearize(COEFFICIENTS, near)
    np.testing.assert_allclose(tilted.theta, np.array(near) + 0.05, atol=1e-10)
    np.testing.assert_allclose(tilted.A, level.A, atol=1e-5)


def test_a_compliant_base_adds_its_acceleration_to_the_rods():
    compliance = 1e-4
    at = EQUILIBRIA["hanging"]
    stiff = linearize(COEFFICIENTS, at)
    soft = linearize(COEFFICIENTS, at, acting(("pivot_compliance.base", [compliance])))
    # The cart moves by x = -compliance h theta'' under the rods' horizontal pull, theta the deviations from hanging.
    rods = stiff.A[np.ix_(RODS, RODS)]
    A23, _, a1, _, _, L, _ = COEFFICIENTS
    pull = -np.array([a1, A23 / L]) @ rods[2:]
    x_second = -compliance * pull @ rods @ rods
    np.testing.assert_allclose(
        soft.A[4:, RODS] - rods[2:], stiff.B[4:] * x_second, rtol=2e-5, atol=2e-5 * np.abs(x_second).max()
    )


@pytest.mark.parametrize(
    "effect",
    # What has states of its own has no part in a linear model of the rods alone.
    [e for e in CATALOGUE if not e.brings_states],
    ids=lambda effect: effect.key,
)
def test_an_effect_has_a_linear_part_just_where_the_smallest_motions_feel_it_in_proportion(effect):
    typical = [parameter.typical for parameter in effect.parameters]
    alone, still, late = acting((effect, typical)), np.zeros(1), np.full(1, 10.0 if effect.at_an_instant else 0.0)

    def added(state):
        moved = accelerations_at(COEFFICIENTS, state[None], still, alone, late)
        return moved - accelerations_at(COEFFICIENTS, state[None], still)

    size, rest = 1e-7, np.array([*EQUILIBRIA["hanging"], 0.0, 0.0])
    away = size * np.array([1.0, 2.0, 1.0, 2.0])
    change = np.abs(added(rest + away) - added(rest - away)).max() + size * np.abs(added(rest)).max()
    is_linear = effect not in without_linear_part(COEFFICIENTS, EQUILIBRIA["hanging"], alone)
    assert is_linear == (not effect.dry and change > 1e-3 * size * abs(typical[0]))


@pytest.mark.parametrize(
    "key",
    [
        "coulomb_friction.inner", "stribeck_friction.outer", "load_friction.inner", "quadratic_friction.outer",
        "air_drag.outer.strips", "impulse.inner", "presliding_friction.outer", "encoder_scale.inner",
    ],
)  # fmt: skip
def test_what_has_no_linear_part_changes_nothing(key):
    plain = linearize(COEFFICIENTS, EQUILIBRIA["upright"])
    np.testing.assert_array_equal(linearize(COEFFICIENTS, EQUILIBRIA["upright"], acting(key)).A, plain.A)


def test_a_spring_that_is_stronger_than_gravity_leaves_nothing_upright():
    with pytest.raises(OptionError, match="do not rest"):
        linearize(COEFFICIENTS, EQUILIBRIA["upright"], acting(("joint_spring.inner", [40.0, 0.0])))


@given(values=pendulums())
def test_hanging_everything_decays_and_upright_both_rods_fall_and_the_cart_controls_every_mode(values):
    coefficients = physical_coefficients(values)
    hanging, upright = (linearize(coefficients, EQUILIBRIA[at]) for at in ("hanging", "upright"))
    assert all(mode.eigenvalue.real < 0.0 for mode in hanging.modes)
    assert sum(mode.eigenvalue.real > 0.0 for mode in upright.modes) == 2
    assert all(mode.damping < 0.0 for mode in upright.modes if mode.eigenvalue.real > 0.0)
    assert all(linearize(coefficients, near).controllable for near in EQUILIBRIA.values())
    swinging = Mode(complex(-0.3, 0.4))
    assert (swinging.frequency, swinging.damping) == pytest.approx((0.5, 0.6))


def test_an_outer_rod_that_hangs_on_its_centre_of_mass_cannot_be_controlled():
    balanced = TABLE_2 | {"l2": 0.0, "c2": 0.0}
    model = linearize(physical_coefficients(balanced), EQUILIBRIA["upright"])
    assert not model.controllable
