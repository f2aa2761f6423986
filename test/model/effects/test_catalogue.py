# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The catalogue's effects: their names, what follows from their formulas, and torques as described independently.

Tests go over the catalogue by themselves: an effect that is added there is tried here.
"""

import math
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.curves import CURVES, basis
from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State
from cdp_ident.model.motions import accelerations_at
from reference import described, pendulum
from reference.pendulum import TABLE_5
from scenarios.effects import EFFECTS, acting, typical
from scenarios.paper_rig import A22, COEFFICIENTS

SIZE = 3e-3
"""Strength of an effect in its unit."""
OUTER_LENGTH = 2 * TABLE_5["l2"] + np.random.default_rng(0).random(2)[1] * (TABLE_5["L"] - 2 * TABLE_5["l2"])
"""Of the rod whose drag is described independently [m]."""
DISSIPATIVE = [effect for effect in CATALOGUE if effect.dry or effect.name in ("quadratic_friction", "air_drag")]
STATES = np.random.default_rng(1).normal(scale=[3.0, 3.0, 6.0, 6.0], size=(40, 4))
JOINTS = ("inner", "outer")


def torque_of(effect, state, values, time=0.0, outer_length=OUTER_LENGTH):
    """Return the generalised torques (2,) of an effect over A22: what it takes to accelerate the rods as it does."""
    alone, states, still = ActingEffects.of([(effect, values)], outer_length), np.array([state]), np.zeros(1)
    added = accelerations_at(COEFFICIENTS, states, still, alone, np.array([time]))
    added -= accelerations_at(COEFFICIENTS, states, still)
    coupling = COEFFICIENTS[0] * math.cos(state[0] - state[1])
    return np.array([[1.0, coupling], [coupling, COEFFICIENTS[1]]]) @ added[0]


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
    for state in STATES[:2]:
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
    yield "gravity_tilt.base", [SIZE], described.tilt()
    yield "air_drag.inner", [over], described.drag("inner", np.random.default_rng(0))
    yield "air_drag.outer.rotation", [over], described.drag("outer", np.random.default_rng(2))
    yield "air_drag.outer.strips", [over, 1.0], described.drag("outer", np.random.default_rng(0))
    for joint, mass in (("inner", TABLE_5["m1"] + TABLE_5["m0"] + TABLE_5["m2"]), ("outer", TABLE_5["m2"])):
        cogging = [over * math.cos(phase), over * math.sin(phase), periods]
        yield f"coulomb_friction.{joint}", [over], described.dry(joint)
        dry = [over, more * over, slow]
        yield f"stribeck_friction.{joint}", dry, described.stribeck(joint, np.random.default_rng(2))
        yield f"quadratic_friction.{joint}", [over], described.quadratic(joint)
        yield f"load_friction.{joint}", [SIZE, mass / A22], described.load_friction(joint)
        spring = [over, over * at_ease]
        yield f"joint_spring.{joint}", spring, described.spring(joint, np.random.default_rng(3))
        key = f"cogging_torque.{joint}.{periods} per turn"
        yield key, cogging, described.cogging(joint, np.random.default_rng(4))


@pytest.mark.parametrize(
    ("key", "values", "other"), described_twice(), ids=lambda value: value if isinstance(value, str) else ""
)
def test_a_torque_is_that_of_an_independent_description(key, values, other):
    for state in STATES:
        if min(abs(state[2]), abs(state[3] - state[2])) < 0.5:
            continue  # near rest dry friction is smooth there
        expected = np.array(other(0.0, tuple(state), TABLE_5, SIZE))
        found = torque_of(EFFECTS[key], state, values) * A22
        # Drag is summed over so few strips there that a rod with a standing point along it shows the difference.
        tolerance = 0.03 if "strips" in key else 1e-4
        assert np.linalg.norm(found - expected) < tolerance * np.linalg.norm(expected) + 1e-4 * SIZE


@pytest.mark.parametrize("joint", JOINTS)
def test_an_impulse_gives_its_rod_its_impulse(joint):
    times = np.linspace(0.9, 1.1, 401)
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


@given(state=st.tuples(*[st.floats(-10.0, 10.0)] * 2, *[st.floats(-20.0, 20.0)] * 2), ratio=st.floats(0.3, 3.0))
def test_drag_of_a_body_at_a_rod_s_end_takes_the_power_that_its_speed_says(state, ratio):
    theta1, theta2, omega1, omega2 = state
    lever, by = TABLE_5["L"] / (ratio * OUTER_LENGTH), np.exp(1j * np.array([theta1, theta2]))
    speed = abs(lever * omega1 * by[0] + omega2 * by[1])
    torque = torque_of(EFFECTS["air_drag.outer.bob"], state, [0.01, ratio])
    assert torque @ [omega1, omega2] == pytest.approx(-0.01 * speed**3, rel=1e-6, abs=1e-9)
    # A body that the inner rod alone carries along is braked along that rod's circle.
    carried = torque_of(EFFECTS["air_drag.outer.bob"], (theta1, theta1, omega1, 0.0), [0.01, ratio])
    assert carried[0] == pytest.approx(-0.01 * lever**3 * omega1 * abs(omega1), rel=1e-6, abs=1e-9)


KINDS = [
    # Errors of encoders, and what bends under them, do not move the rods.
    (lambda e: not e.moves,
     {"encoder_offset", "encoder_scale", "encoder_eccentricity", "encoder_slip", "time_offset", "backlash", "rod_flex",
      "encoder_harmonic", "encoder_compliance", "encoder_filter", "oblique_view", "encoder_interpolation"}),
    (lambda e: e.repeats, {"encoder_interpolation"}),
    (lambda e: e.of_both_encoders, {"rod_flex", "oblique_view"}),
    # Dry friction is what has a formula of its size.
    (lambda e: e.dry, {"coulomb_friction", "stribeck_friction", "drifting_friction", "load_friction",
                       "unknown_torque.inner.friction_over_angle", "unknown_torque.outer.friction_over_angle"}),
    (lambda e: e.uses_accelerations,
     {"geared_rotor", "pivot_compliance", "rod_flex", "encoder_compliance", "encoder_filter"}),
    # Torques of a joint's angle alone, and of its angle and speed.
    (lambda e: e.of_angle and not e.harmonic,
     {"joint_spring", "constant_torque", "magnet",
      "unknown_torque.inner.over_angle", "unknown_torque.outer.over_angle"}),
    (lambda e: e.words == {"speed"} and e.moves and not (e.dry or e.curve), {"quadratic_friction"}),
    # States belong to what remembers, swings or has play.
    (lambda e: e.remembers, {"presliding_friction"}),
    (lambda e: e.is_local, {"magnet", "end_stop", *(f"varying_viscosity.{joint}.near a place" for joint in JOINTS)}),
    (lambda e: e.states and not e.moves, {"backlash", "encoder_filter", "encoder_compliance"}),
    (lambda e: e.brings_states, {"presliding_friction", "pivot_compliance.base.oscillating"}),
    (lambda e: e.states and e.known_at_zero, {"backlash"}),
]  # fmt: skip


@pytest.mark.parametrize(("has", "expected"), KINDS)
def test_what_an_effect_is_is_known_from_its_formulas(has, expected):
    """Each by its name, or by its key where other effects of the name are not all so."""
    found = [effect for effect in CATALOGUE if has(effect)]
    assert {effect.key if effect.key in expected else effect.name for effect in found} == expected


def test_a_law_in_one_line_names_its_states_and_what_its_names_stand_for():
    law = Law(torque="-size*bend*slope", where=(("slope", "1 + angle^2"),), states=(State("bend", "speed"),))
    effect = Effect("mine", "inner", "mine", law, (EffectParameter("size", "N m", 0.0, 1.0, 0.1),), "mine")
    assert effect.formula == "torque = -size*bend*slope; bend' = speed; slope = 1 + angle^2"
    assert (effect.states, effect.remembers, effect.words, effect.of_angle) == (1, True, {"angle", "speed"}, False)
    assert replace(effect, law=Law(reading="size*angle")).moves is False


def test_an_error_over_the_angle_of_another_form_is_not_looked_for_in_a_spectrum():
    """As one that a user writes, whose parameters are others."""
    of_catalogue = next(effect for effect in CATALOGUE if effect.repeats)
    size, times = (
        replace(p, name=name) for p, name in zip(of_catalogue.parameters[1:], ("size", "times"), strict=True)
    )
    own = replace(of_catalogue, law=Law(reading="size*sin(times*angle)"), parameters=(size, times))
    assert not own.repeats
    assert own.has_score


EACH = pytest.mark.parametrize("effect", CURVES, ids=lambda effect: effect.key)


@EACH
def test_the_compiled_law_is_the_spline_of_its_basis(effect):
    at = np.random.default_rng(0).normal(scale=8.0, size=300)
    values = np.random.default_rng(1).uniform(0.0, 1.0, effect.curve.count)
    angle, speed = (at, np.ones(300)) if effect.curve.over == "angle" else (np.ones(300), at)
    inner, zero = effect.joint == "inner", np.zeros(300)
    states = np.stack([angle + math.pi, zero, speed, zero] if inner else [zero, angle, zero, speed], axis=1)
    curve = acting((effect, values))
    added = accelerations_at(COEFFICIENTS, states, zero, curve) - accelerations_at(COEFFICIENTS, states, zero)
    coupling = COEFFICIENTS[0] * np.cos(states[:, 0] - states[:, 1])
    torques = added[:, 0] + coupling * added[:, 1], coupling * added[:, 0] + COEFFICIENTS[1] * added[:, 1]
    expected = (-1.0 if effect.dry else 1.0) * basis(effect.curve, at) @ values
    np.testing.assert_allclose(torques, [expected, zero] if inner else [-expected, expected], atol=1e-10)


@EACH
def test_equal_coefficients_are_an_even_torque_and_four_at_most_are_felt_anywhere(effect):
    contributions = basis(effect.curve, np.linspace(-50.0, 50.0, 1001))
    np.testing.assert_allclose(contributions.sum(axis=1), 1.0, rtol=1e-12)
    assert np.count_nonzero(contributions > 1e-15, axis=1).max() == 4


@EACH
def test_over_the_angle_it_repeats_with_each_turn_and_speeds_beyond_all_that_occur_change_nothing_more(effect):
    if effect.curve.over == "angle":
        at = np.linspace(-3.0, 3.0, 50)
        np.testing.assert_allclose(basis(effect.curve, at + 4.0 * math.pi), basis(effect.curve, at), atol=1e-12)
    else:
        np.testing.assert_array_equal(*(basis(effect.curve, np.array([at])) for at in (1e3, 1e6)))
