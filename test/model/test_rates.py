# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Accelerations are the Lagrangian's; a base that swings and a geared rotor are those of independent rigid bodies."""

import math

import numba
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cdp_ident.model.acting import NO_EFFECTS
from cdp_ident.model.motions import accelerations_at, jacobians_at, simulate
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.model.rates import sine_and_cosine
from cdp_ident.model.time_grid import DEFAULT_STEP
from reference import pendulum
from reference.dry_friction import NO_FRICTION, DryFriction
from reference.mechanics import Cart, Rig
from reference.pendulum import TABLE_2, TABLE_5
from reference.plant import Plant
from reference.sticking import path
from reference.strategies import pendulums, starts
from scenarios.effects import EFFECTS, acting
from scenarios.paper_rig import A22, COEFFICIENTS

RODS = TABLE_5["m1"] + TABLE_5["m2"] + TABLE_5["m0"]
TIMES = np.arange(1001) * 0.005
START = np.array([np.pi + 0.7, np.pi - 0.5, 0.0, 0.0])


def simulated(coefficients, effects, start=START, step=DEFAULT_STEP):
    return simulate(coefficients, start, TIMES, None, step, acting(*effects))


def base(mass, compliance, damping_ratio):
    """Return the effect with its values, and the reference's cart: what moves along weighs `mass` [kg]."""
    damping = 2.0 * damping_ratio * math.sqrt(mass / compliance)
    cart = Cart(mass - RODS, 1.0 / compliance, damping)
    return (
        "pivot_compliance.base.oscillating",
        (compliance * A22, 1.0 / math.sqrt(compliance * mass), damping_ratio),
    ), cart


BASES = pytest.mark.parametrize(
    ("mass", "compliance", "damping_ratio"), [(0.6, 1e-3, 0.05), (1.0, 3e-4, 0.3), (5.0, 1e-2, 0.0), (1.0, 1e-2, 1.5)]
)


@BASES
def test_a_base_on_a_spring_swings_as_the_reference_s_cart(mass, compliance, damping_ratio):
    effect, cart = base(mass, compliance, damping_ratio)
    expected = path(Plant(Rig(TABLE_5, cart=cart)), START, TIMES)
    found = simulated(COEFFICIENTS, [effect])
    assert np.ptp(expected.cart) > 1e-4
    # The first of them swings several times as fast as the rods, for which the step is made.
    assert np.abs(found[:, :2] - expected.states[:, :2]).max() < 2e-6
    assert np.abs(found[:, 4] - expected.cart).max() < 1e-6


@pytest.mark.parametrize(("inner", "outer"), [(3.0, 0.0), (0.0, 1.0), (3.0, 1.0), (20.0, 0.1)])
def test_joints_stick_over_a_base_that_swings_as_in_the_reference(inner, outer):
    effect, cart = base(1.0, 1e-3, 0.1)
    frictions = [("inner", inner), ("outer", outer)]
    effects = [(f"coulomb_friction.{joint}", (torque,)) for joint, torque in frictions if torque]
    dry = [DryFriction(torque * A22) if torque else NO_FRICTION for _, torque in frictions]
    expected = path(Plant(Rig(TABLE_5, cart=cart), *dry), START, TIMES)
    found = simulated(COEFFICIENTS, [*effects, effect])
    assert np.abs(found[:, :2] - expected.states[:, :2]).max() < 1e-6
    assert np.abs(found[:, 4] - expected.cart).max() < 1e-6


def test_a_stiff_compliant_base_moves_as_the_quasi_static_one():
    compliance = 3e-6
    (oscillating, values), _ = base(2.0, compliance, 0.2)
    A23, _, a1, _, _, L, _ = COEFFICIENTS
    alpha = accelerations_at(COEFFICIENTS, START[None], np.zeros(1))[0]
    pull = a1 * math.cos(START[0]) * alpha[0] + A23 / L * math.cos(START[1]) * alpha[1]
    gives = np.array([*START, -values[0] * pull, 0.0])
    swings = simulated(COEFFICIENTS, [(oscillating, values)], gives, 0.0005)
    follows = simulated(COEFFICIENTS, [("pivot_compliance.base", (compliance * A22,))])
    rigid = simulated(COEFFICIENTS, [])
    change = np.abs(follows - rigid)[:, :2].max()
    assert np.abs(swings[:, :2] - follows[:, :2]).max() < 0.05 * change


def geared(inertia):
    """Return the coefficients of a rig with a rotor that turns with the joint, and the effect with its value."""
    A23, A33, a1, c1, c2, L, g = COEFFICIENTS
    whole = A22 + inertia
    share = A22 / whole
    coefficients = np.array([A23 * share, A33 * share + inertia / whole, a1 * share, c1 * share, c2 * share, L, g])
    return coefficients, ("geared_rotor.outer", (-inertia / whole,))


@pytest.mark.parametrize("inertia", [1e-4, 1e-3, 5e-3])
def test_a_geared_rotor_is_the_reference_s(inertia):
    coefficients, effect = geared(inertia)
    expected = path(Plant(Rig(TABLE_5, rotor=inertia)), START, TIMES)
    assert np.abs(simulated(coefficients, [effect])[:, :2] - expected.states[:, :2]).max() < 1e-6


@pytest.mark.parametrize(("inner", "outer"), [(3.0, 1.0), (20.0, 0.1), (0.3, 5.0)])
def test_joints_with_a_geared_rotor_stick_as_in_the_reference(inner, outer):
    coefficients, effect = geared(1e-3)
    joints = [("coulomb_friction.inner", (inner,)), ("coulomb_friction.outer", (outer,))]
    dry = [DryFriction(torque * (A22 + 1e-3)) for torque in (inner, outer)]
    expected = path(Plant(Rig(TABLE_5, rotor=1e-3), *dry), START, TIMES)
    found = simulated(coefficients, [effect, *joints])
    assert np.abs(found[:, :2] - expected.states[:, :2]).max() < 1e-6


@given(values=pendulums(), state=starts(speed=30.0), u=st.floats(-20, 20))
@example(values=TABLE_2, state=np.array([0.0, np.pi, 0.0, 0.0]), u=0.0)
def test_accelerations_are_those_of_the_lagrangian(values, state, u):
    expected = pendulum.accelerations(values, state, u)
    (found,) = accelerations_at(physical_coefficients(values), state[None], np.array([u]))
    # At an equilibrium both are rounding only, of torques that cancel.
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-9 * np.abs(expected).max() + 1e-12)


@pytest.mark.parametrize("key", [None, "joint_spring.inner", "coulomb_friction.outer", "geared_rotor.outer"])
def test_accelerations_are_the_slopes_of_the_motion(key):
    effects, start = acting(*([key] if key else [])), np.array([3.4, 3.9, -3.5, 11.2])
    states = simulate(COEFFICIENTS, start, np.array([0.0, 1e-5]), None, 1e-5, effects)
    found = accelerations_at(COEFFICIENTS, states, np.zeros(2), effects)
    np.testing.assert_allclose(found.mean(axis=0), (states[1, 2:] - states[0, 2:]) / 1e-5, rtol=1e-6)


@pytest.mark.parametrize("key", EFFECTS)
def test_jacobians_are_those_of_differences_of_the_accelerations(key):
    effects = acting(key)
    forwards = np.random.default_rng(3).normal([0.0, 0.0, 9.0, 20.0], [3.0, 3.0, 1.0, 1.0], size=(3, 4))
    states = np.hstack([forwards, np.full((3, effects.states - 4), 1e-3)])
    found = jacobians_at(COEFFICIENTS, states, effects)
    for k, step in enumerate(1e-5 * np.eye(effects.states)):
        ahead, behind = (accelerations_at(COEFFICIENTS, states + s * step, np.zeros(3), effects) for s in (1, -1))
        expected = (ahead - behind) / 2e-5
        assert np.abs(found[:, :, k] - expected).max() < 1e-6 * max(np.abs(expected).max(), 10.0)


def test_accelerations_at_rest_are_those_of_joints_that_stick_where_they_can():
    effects = acting(("coulomb_friction.inner", (20.0,)), ("coulomb_friction.outer", (0.1,)))
    rest = np.array([[2.2, 2.6, 0.0, 0.0], [np.pi, np.pi, 0.0, 0.0], [2.2, 2.6, 0.1, 0.1]])
    found = accelerations_at(COEFFICIENTS, rest, np.zeros(3), effects)
    dry = DryFriction(20.0 * A22), DryFriction(0.1 * A22)
    expected = [path(Plant(Rig(TABLE_5), *dry), state, TIMES[:1]).accelerations[0] for state in rest]
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert found[0, 0] == 0.0
    assert np.all(found[1] == 0.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_end_stop_pushes_a_joint_back_and_does_not_pull_one_that_leaves_it_fast(side):
    stop = acting(("end_stop.outer", (10.0, 0.5 * side, 0.2)))
    at = side * 0.6  # [rad]
    states = np.array([[np.pi, np.pi + at, 0.0, side * speed] for speed in (2.0, 0.0, -2.0, -5.0, -9.0)])
    alone, held = (accelerations_at(COEFFICIENTS, states, np.zeros(5), effects) for effects in (NO_EFFECTS, stop))
    pushed = -side * ((held - alone) @ [-1.0, 1.0])
    assert pushed[0] > pushed[1] > pushed[2] > 0.0
    np.testing.assert_allclose(pushed[3:], 0.0, atol=1e-9)


@numba.njit
def sines_and_cosines(angles):
    result = np.empty((len(angles), 2))
    for i in range(len(angles)):
        result[i, 0], result[i, 1] = sine_and_cosine(angles[i])
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
