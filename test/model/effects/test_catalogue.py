# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The catalogue's effects: their names, and torques as described independently.

Tests go over the catalogue by themselves: an effect that is added there is tried here.
"""

import math
from itertools import cycle

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.motions import accelerations_at
from cdp_ident.model.parameters import SYMBOLS, inertia_about_cart, physical_coefficients
from reference import hidden_effects, pendulum
from reference.pendulum import TABLE_5

EFFECTS = {effect.key: effect for effect in CATALOGUE}
A22 = float(inertia_about_cart([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"]))
COEFFICIENTS = physical_coefficients(TABLE_5)
SIZE = 3e-3
"""Strength of an effect in its unit."""
OUTER_LENGTH = 2 * TABLE_5["l2"] + np.random.default_rng(0).random(2)[1] * (TABLE_5["L"] - 2 * TABLE_5["l2"])
"""Of the rod whose drag is described independently [m]."""
DISSIPATIVE = [effect for effect in CATALOGUE if effect.dry or effect.name in ("quadratic_friction", "air_drag")]
STATES = np.random.default_rng(1).normal(scale=[3.0, 3.0, 6.0, 6.0], size=(40, 4))
JOINTS = ("inner", "outer")


def torque_of(effect, state, values, time=0.0, outer_length=OUTER_LENGTH):
    """Return the generalised torques (2,) of an effect over A22: what it takes to accelerate the rods as it does."""
    acting, states, still = ActingEffects.of([(effect, values)], outer_length), np.array([state]), np.zeros(1)
    added = accelerations_at(COEFFICIENTS, states, still, acting, np.array([time]))
    added -= accelerations_at(COEFFICIENTS, states, still)
    coupling = COEFFICIENTS[0] * math.cos(state[0] - state[1])
    return np.array([[1.0, coupling], [coupling, COEFFICIENTS[1]]]) @ added[0]


def typical(effect):
    values = [parameter.typical for parameter in effect.parameters]
    return [values[0], 0.305] if effect.at_an_instant else values


def test_the_names_are_those_that_reports_promise():
    assert {(effect.name, effect.joint) for effect in CATALOGUE} == {
        *((name, joint) for name in (
            "coulomb_friction", "stribeck_friction", "presliding_friction", "quadratic_friction", "load_friction",
            "air_drag", "joint_spring", "cogging_torque", "impulse", "encoder_offset", "encoder_scale",
            "encoder_eccentricity", "encoder_slip", "backlash", "constant_torque", "varying_viscosity",
            "drifting_friction", "encoder_harmonic", "encoder_compliance", "encoder_filter", "magnet", "end_stop",
            "drifting_viscosity", "encoder_interpolation",
        ) for joint in JOINTS),
        *(("unknown_torque", joint) for joint in JOINTS),
        ("gravity_tilt", "base"),
        ("side_force", "base"),
        ("pivot_compliance", "base"),
        ("geared_rotor", "outer"),
        ("time_offset", "outer"),
        ("rod_flex", "inner"),
        ("oblique_view", "base"),
    }  # fmt: skip


def test_every_effect_says_what_it_is_has_a_key_of_its_own_and_begins_within_its_limits():
    assert len(EFFECTS) == len(CATALOGUE)
    for effect in CATALOGUE:
        assert effect.description, effect.key
        assert effect.formula, effect.key
        assert all(state.name and state.rate for state in effect.law.states), effect.key
        for parameter in effect.parameters:
            assert parameter.unit, effect.key
            assert parameter.lower <= parameter.typical <= parameter.upper, effect.key
            assert parameter.typical == parameter.lower or not parameter.fixed, effect.key


def test_a_compliant_base_is_accelerated_by_the_fourth_derivative_of_what_the_rods_carry():
    A23, _, a1, _, _, L, _ = COEFFICIENTS
    effect, compliance, near = EFFECTS["pivot_compliance.base"], 1e-5, 0.05
    for state in STATES[:5]:
        moved, _ = torque_of(effect, state, [compliance])
        nodes = near * np.polynomial.chebyshev.chebpts1(41)
        ways = [
            solve_ivp(
                lambda t, y: [*y[2:], *pendulum.accelerations(TABLE_5, y, 0.0)], (0.0, side[-1]), state,
                method="DOP853", t_eval=side, rtol=1e-12, atol=1e-12,
            ).y[:2].T
            for side in (nodes[nodes < 0.0][::-1], nodes[nodes >= 0.0])
        ]  # fmt: skip
        theta = np.concatenate([ways[0][::-1], ways[1]])
        carried = np.sin(theta) @ [a1, A23 / L]
        fourth = np.polynomial.Chebyshev.fit(nodes, carried, 24, domain=[-near, near]).deriv(4)(0.0)
        assert moved == pytest.approx(compliance * fourth * a1 * math.cos(state[0]), rel=1e-4)


@given(
    state=st.tuples(*[st.floats(-10.0, 10.0)] * 2, *[st.floats(-20.0, 20.0)] * 2),
    shares=st.tuples(*[st.floats(0.0, 1.0)] * 3),
)
def test_friction_never_feeds_energy_in(state, shares):
    for effect in DISSIPATIVE:
        drawn = zip(effect.parameters, cycle(shares), strict=False)
        values = [p.lower + share * (p.upper - p.lower) for p, share in drawn]
        torque = torque_of(effect, state, values)
        assert torque @ state[2:] <= 1e-9 * (1.0 + np.abs(torque) @ np.abs(state[2:]))


@pytest.mark.parametrize("effect", DISSIPATIVE, ids=lambda effect: effect.key)
def test_friction_takes_energy_from_every_motion_of_its_joint(effect):
    values = typical(effect)
    assert all(torque_of(effect, state, values) @ state[2:] < 0 for state in STATES)


def draws(seed, *limits):
    rng = np.random.default_rng(seed)
    return [rng.uniform(*each) for each in limits]


def described_twice():
    """Return effects, their values, and the same ones in an independent description, of strength SIZE."""
    slow, more = draws(2, (0.3, 1.5), (0.6, 1.5))
    (at_ease,) = draws(3, (-0.3, 0.3))
    rng = np.random.default_rng(4)
    periods, phase = int(rng.integers(3, 17)), rng.uniform(-math.pi, math.pi)
    over = SIZE / A22
    yield "gravity_tilt.base", [SIZE], hidden_effects.tilt()
    yield "air_drag.inner", [over], hidden_effects.drag("inner", np.random.default_rng(0))
    yield "air_drag.outer.rotation", [over], hidden_effects.drag("outer", np.random.default_rng(2))
    yield "air_drag.outer.strips", [over, 1.0], hidden_effects.drag("outer", np.random.default_rng(0))
    for joint, mass in (("inner", TABLE_5["m1"] + TABLE_5["m0"] + TABLE_5["m2"]), ("outer", TABLE_5["m2"])):
        cogging = [over * math.cos(phase), over * math.sin(phase), periods]
        yield f"coulomb_friction.{joint}", [over], hidden_effects.dry(joint)
        dry = [over, more * over, slow]
        yield f"stribeck_friction.{joint}", dry, hidden_effects.stribeck(joint, np.random.default_rng(2))
        yield f"quadratic_friction.{joint}", [over], hidden_effects.quadratic(joint)
        yield f"load_friction.{joint}", [SIZE, mass / A22], hidden_effects.load_friction(joint)
        spring = [over, over * at_ease]
        yield f"joint_spring.{joint}", spring, hidden_effects.spring(joint, np.random.default_rng(3))
        key = f"cogging_torque.{joint}.{periods} per turn"
        yield key, cogging, hidden_effects.cogging(joint, np.random.default_rng(4))


@pytest.mark.parametrize(
    ("key", "values", "other"), described_twice(), ids=lambda value: value if isinstance(value, str) else ""
)
def test_a_torque_is_that_of_an_independent_description(key, values, other):
    for state in STATES:
        if min(abs(state[2]), abs(state[3] - state[2])) < 0.5:
            continue  # near rest dry friction is smooth there
        expected = np.array(other.torque(0.0, tuple(state), TABLE_5, SIZE))
        found = torque_of(EFFECTS[key], state, values) * A22
        # Drag is summed over so few strips there that a rod with a standing point along it shows the difference.
        tolerance = 0.03 if "strips" in key else 1e-4
        assert np.linalg.norm(found - expected) < tolerance * np.linalg.norm(expected) + 1e-4 * SIZE


@pytest.mark.parametrize("joint", JOINTS)
def test_an_impulse_gives_its_rod_its_impulse(joint):
    times = np.linspace(0.9, 1.1, 2001)
    torques = [torque_of(EFFECTS[f"impulse.{joint}"], STATES[0], [0.7, 1.0], time) for time in times]
    given_to = np.trapezoid(torques, times, axis=0)
    assert given_to == pytest.approx([0.7, 0.0] if joint == "inner" else [0.0, 0.7], rel=1e-6)


@given(
    state=st.tuples(*[st.floats(-10.0, 10.0)] * 2, *[st.floats(-20.0, 20.0)] * 2),
    ratio=st.floats(0.3, 3.0),
)
@example(state=(1.0, 1.0, 0.0, 0.0), ratio=1.0)
@example(state=(1.0, 1.0, 5.0, -6.0), ratio=1.0)
def test_drag_along_a_rod_is_the_integral_over_it_wherever_the_air_comes_from(state, ratio):
    theta1, theta2, omega1, omega2 = state
    lever = TABLE_5["L"] / (ratio * OUTER_LENGTH) * math.cos(theta1 - theta2)
    place = (np.arange(100_000) + 0.5) / 100_000
    across = lever * omega1 + place * omega2
    pressure = -4.0 * 0.01 * across * np.abs(across) / len(place)
    expected = np.array([lever * pressure.sum(), (place * pressure).sum()])
    found = torque_of(EFFECTS["air_drag.outer.strips"], state, [0.01, ratio])
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-6)
