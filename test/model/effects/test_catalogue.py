"""The catalogue's effects: their names, torques as described independently, and slopes.

Tests go over the catalogue by themselves: an effect that is added there is tried here.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cdp_ident.model.effects.catalogue import CATALOGUE, curve_law, joint_law, kind_of, memory_law, rods_law
from cdp_ident.model.effects.constants import effect_constants
from cdp_ident.model.effects.effect import Form, TorqueEffect, exclude_each_other
from cdp_ident.model.equations import sines_and_cosines
from cdp_ident.model.parameters import SYMBOLS, inertia_about_cart, physical_coefficients
from cdp_ident.model.torques import Torques
from reference import hidden_effects, pendulum
from reference.pendulum import TABLE_5

EFFECTS = {effect.key: effect for effect in CATALOGUE}
TORQUES = [effect for effect in CATALOGUE if isinstance(effect, TorqueEffect)]
A22 = float(inertia_about_cart([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"]))
COEFFICIENTS = physical_coefficients(TABLE_5)
SIZE = 3e-3
"""Strength of an effect in its unit."""
OUTER_LENGTH = 2 * TABLE_5["l2"] + np.random.default_rng(0).random(2)[1] * (TABLE_5["L"] - 2 * TABLE_5["l2"])
"""Of the rod whose drag is described independently [m]."""
CONSTANTS = effect_constants(COEFFICIENTS, TABLE_5["L"], OUTER_LENGTH)
DISSIPATIVE = [effect for effect in TORQUES if effect.dry or effect.name in ("quadratic_friction", "air_drag")]
STATES = np.random.default_rng(1).normal(scale=[3.0, 3.0, 6.0, 6.0], size=(40, 4))
JOINTS = ("inner", "outer")


LAWS = [effect for effect in TORQUES if effect.form in (Form.JOINT, Form.RODS, Form.CURVE)]
WITH_MEMORY = [effect for effect in TORQUES if effect.form is Form.MEMORY]
MOST = max(len(effect.parameters) for effect in TORQUES)
BY_STATE, BY_COEFFICIENTS, BY_PARAMETERS = slice(0, 4), slice(4, 11), 11
"""Where in slopes the derivatives by what are."""


def test_there_is_room_for_the_states_of_all_effects_that_may_be_together():
    together = []
    for effect in sorted(TORQUES, key=lambda effect: -effect.states):
        if effect.brings_states and not any(exclude_each_other(effect, other) for other in together):
            together.append(effect)
    chosen = [(effect, [p.typical for p in effect.parameters]) for effect in together]
    assert Torques.of(chosen, CONSTANTS).states == 4 + sum(effect.states for effect in together)
    with pytest.raises(ValueError, match="room"):
        Torques.of([*chosen, *chosen], CONSTANTS)


def three(values):
    """Return the parameters that a law takes which is no curve."""
    return tuple([*values, 0.0, 0.0, 0.0][:3])


def of_joint(effect, angle, speed, values):
    """Return the torque of an effect of form JOINT or CURVE, and its slopes (2 + parameters,)."""
    if effect.form is Form.CURVE:
        values = np.pad(values, (0, effect.curve.count - len(values)))
        slopes = np.zeros((2, 2 + len(values)))
        return curve_law(kind_of(effect), angle, speed, values[None], 0, slopes), slopes[0]
    torque, by_angle, by_speed, by = joint_law(kind_of(effect), angle, speed, three(values))
    return torque, np.array([by_angle, by_speed, *by])


def law_of(effect, state, values, time=0.0, constants=CONSTANTS):
    """Return the generalised torques (2,) of an effect, dry ones against the motion, and their slopes (2, …)."""
    inner = effect.joint == "inner"
    angle, speed = (state[0] - math.pi, state[2]) if inner else (state[1] - state[0], state[3] - state[2])
    onto = np.array([1.0, 0.0] if inner else [-1.0, 1.0])
    factor = -np.sign(speed) if effect.dry else 1.0
    if effect.form is Form.RODS:
        torque1, torque2, x, y, to1, to2, by1, by2 = rods_law(
            kind_of(effect), tuple(state), sines_and_cosines(*state[:2]), time, three(values), tuple(constants)
        )
        slopes = np.array([[*x, *to1, *by1], [*y, *to2, *by2]])
        if not effect.dry:
            return np.array([torque1, torque2]), slopes
        return factor * torque1 * onto, factor * np.outer(onto, slopes[0])
    torque, by = of_joint(effect, angle, speed, values)
    turned = np.concatenate([by[0] * onto if not inner else [by[0], 0.0], by[1] * onto if not inner else [by[1], 0.0]])
    whole = np.concatenate([turned, np.zeros(7), by[2:]])
    return factor * torque * onto, factor * np.outer(onto, whole)


def torque_of(effect, state, values, time=0.0, constants=CONSTANTS):
    return law_of(effect, state, values, time, constants)[0]


def typical(effect):
    values = [parameter.typical for parameter in effect.parameters]
    return [values[0], 0.305] if effect.at_an_instant else values


def test_no_two_effects_have_the_same_key():
    assert len(EFFECTS) == len(CATALOGUE)


def test_the_names_are_those_that_reports_promise():
    assert {(effect.name, effect.joint) for effect in CATALOGUE} == {
        *((name, joint) for name in (
            "coulomb_friction", "stribeck_friction", "presliding_friction", "quadratic_friction", "load_friction",
            "air_drag", "joint_spring", "cogging_torque", "impulse", "encoder_offset", "encoder_scale",
            "encoder_eccentricity", "encoder_slip", "backlash",
        ) for joint in JOINTS),
        *(("unknown_torque", joint) for joint in JOINTS),
        ("gravity_tilt", "base"),
        ("pivot_compliance", "base"),
        ("geared_rotor", "outer"),
        ("time_offset", "outer"),
        ("rod_flex", "inner"),
    }  # fmt: skip


@pytest.mark.parametrize("key", EFFECTS)
def test_every_effect_says_what_it_is_and_begins_within_its_limits(key):
    effect = EFFECTS[key]
    assert effect.description
    assert effect.formula
    for parameter in effect.parameters:
        assert parameter.unit
        assert parameter.lower <= parameter.typical <= parameter.upper


def test_effects_that_need_no_law_are_those_that_dynamics_states():
    assert {effect.key for effect in TORQUES if effect.law is None} == {
        "geared_rotor.outer",
        "pivot_compliance.base.oscillating",
    }
    assert all((effect.law is None) == (effect.form in (Form.COUPLING, Form.BASE)) for effect in TORQUES)


@pytest.mark.parametrize("effect", LAWS, ids=lambda effect: effect.key)
def test_a_law_is_found_by_its_number(effect):
    values = typical(effect)
    for state in STATES[:5]:
        if effect.form is Form.RODS:
            given = tuple(state), sines_and_cosines(*state[:2]), 0.3, three(values), tuple(CONSTANTS)
            found, own = rods_law(kind_of(effect), *given), effect.law(*given)
        elif effect.form is Form.JOINT:
            given = state[0], state[2], three(values)
            found, own = joint_law(kind_of(effect), *given), effect.law(*given)
        else:
            found = of_joint(effect, state[0], state[2], values)
            slopes = np.zeros((2, 2 + len(values)))
            own = effect.law(state[0], state[2], np.array([values]), 0, slopes), slopes[0]
        assert all(np.all(np.asarray(one) == other) for one, other in zip(found, own, strict=True))


def test_a_base_that_gives_way_is_accelerated_by_the_fourth_derivative_of_what_the_rods_carry():
    _, _, a1, _, _, m2_l2, _ = COEFFICIENTS
    effect, compliance, near = EFFECTS["pivot_compliance.base"], 1e-5, 0.05
    for state in STATES[:5]:
        (moved, _), _ = law_of(effect, state, [compliance])
        nodes = near * np.polynomial.chebyshev.chebpts1(41)
        ways = [
            solve_ivp(
                lambda t, y: [*y[2:], *pendulum.accelerations(TABLE_5, y, 0.0)], (0.0, side[-1]), state,
                method="DOP853", t_eval=side, rtol=1e-12, atol=1e-12,
            ).y[:2].T
            for side in (nodes[nodes < 0.0][::-1], nodes[nodes >= 0.0])
        ]  # fmt: skip
        theta = np.concatenate([ways[0][::-1], ways[1]])
        carried = np.sin(theta) @ [a1, m2_l2]
        fourth = np.polynomial.Chebyshev.fit(nodes, carried, 24, domain=[-near, near]).deriv(4)(0.0)
        assert moved == pytest.approx(compliance * fourth * a1 * math.cos(state[0]), rel=1e-4)


@pytest.mark.parametrize("effect", LAWS, ids=lambda effect: effect.key)
def test_a_law_s_slopes_are_those_of_differences(effect):
    values = typical(effect)
    point = np.concatenate([np.zeros(4), COEFFICIENTS, values])
    for state in STATES[:10]:
        point[BY_STATE] = state
        _, slopes = law_of(effect, state, values, 0.3)
        for direction in range(BY_PARAMETERS + len(values)):
            parameter = direction - BY_PARAMETERS
            if parameter >= 0 and effect.parameters[parameter].fixed:
                continue
            if effect.key == "pivot_compliance.base" and 4 <= direction < BY_PARAMETERS:
                continue  # how the pull's own acceleration depends on the coefficients is left out

            def torque(step, direction=direction):
                moved = point.copy()
                moved[direction] += step
                constants = effect_constants(moved[BY_COEFFICIENTS], TABLE_5["L"], OUTER_LENGTH)
                return torque_of(effect, moved[BY_STATE], moved[BY_PARAMETERS:], 0.3, constants)

            step = 1e-5 * max(0.1, abs(point[direction]))
            expected = (torque(step) - torque(-step)) / (2.0 * step)
            tolerance = 1e-5 * (np.abs(expected).max() + np.abs(slopes).max())
            assert np.abs(slopes[:, direction] - expected).max() < tolerance, f"direction {direction}"


@pytest.mark.parametrize("effect", WITH_MEMORY, ids=lambda effect: effect.key)
@pytest.mark.parametrize("speed", [-3.0, -0.1, 0.2, 5.0])
def test_the_slopes_of_a_law_with_a_memory_are_those_of_differences(effect, speed):
    point, scratch = np.array([speed, 0.4, *typical(effect)]), np.zeros((2, BY_PARAMETERS + MOST))

    def law(point):
        values = np.array([[*point[2:], *[0.0] * MOST]])[:, :MOST]
        return np.array(memory_law(kind_of(effect), point[0], np.sign(speed), point[1], values, 0, scratch))

    law(point)
    slopes = scratch[:, : len(point)].copy()
    for k, unit in enumerate(np.eye(len(point))):
        step = 1e-6 * max(abs(point[k]), 1e-3) * unit
        differences = (law(point + step) - law(point - step)) / (2.0 * step[k])
        assert slopes[:, k] == pytest.approx(differences, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("effect", WITH_MEMORY, ids=lambda effect: effect.key)
def test_what_has_a_memory_does_nothing_at_no_strength_and_holds_back_a_joint_that_goes_on(effect):
    values, scratch = np.array([[*typical(effect), *[0.0] * MOST]])[:, :MOST], np.zeros((2, BY_PARAMETERS + MOST))
    without = np.where(np.arange(MOST) == 0, 0.0, values)
    for direction in (-1.0, 1.0):
        speed, own = 2.0 * direction, 0.0
        for _ in range(20000):
            own += 1e-4 * memory_law(kind_of(effect), speed, direction, own, values, 0, scratch)[1]
        assert memory_law(kind_of(effect), speed, direction, own, values, 0, scratch)[0] * speed < 0.0
        assert memory_law(kind_of(effect), speed, direction, own, without, 0, scratch)[0] == 0.0


@given(
    state=st.tuples(*[st.floats(-10.0, 10.0)] * 2, *[st.floats(-20.0, 20.0)] * 2),
    shares=st.tuples(*[st.floats(0.0, 1.0)] * 3),
)
def test_friction_never_feeds_energy_in(state, shares):
    for effect in DISSIPATIVE:
        values = [p.lower + share * (p.upper - p.lower) for p, share in zip(effect.parameters, shares, strict=False)]
        power = torque_of(effect, state, values) @ state[2:]
        assert power <= 1e-9


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


@pytest.mark.parametrize("joint", JOINTS)
def test_a_spring_at_ease_where_the_rods_hang_does_not_move_them_from_there(joint):
    hanging = [math.pi, math.pi, 0.0, 0.0]
    assert np.all(torque_of(EFFECTS[f"joint_spring.{joint}"], hanging, [1.0, 0.0]) == 0.0)


def test_drag_along_a_rod_whose_joint_rests_is_that_of_its_rotation():
    state = [0.3, 1.2, 0.0, 5.0]
    along, alone = (EFFECTS[f"air_drag.outer.{variant}"] for variant in ("strips", "rotation"))
    assert torque_of(along, state, [0.01, 1.0])[1] == pytest.approx(torque_of(alone, state, [0.01])[1], rel=1e-9)


def test_drag_along_a_rod_is_that_of_one_that_is_as_much_longer_as_its_length_ratio_says():
    state, strips = STATES[0], EFFECTS["air_drag.outer.strips"]
    longer = effect_constants(COEFFICIENTS, TABLE_5["L"], 1.4 * OUTER_LENGTH)
    by_ratio = torque_of(strips, state, [0.01, 1.4])
    assert by_ratio == pytest.approx(torque_of(strips, state, [0.01, 1.0], constants=longer), rel=1e-12)
    assert by_ratio != pytest.approx(torque_of(strips, state, [0.01, 1.0]), rel=0.01)


@pytest.mark.parametrize("joint", JOINTS)
def test_stribeck_friction_at_speed_is_dry_friction(joint):
    fast = [0.3, 1.2, 9.0, -9.0]
    plain = torque_of(EFFECTS[f"coulomb_friction.{joint}"], fast, [0.05])
    assert torque_of(EFFECTS[f"stribeck_friction.{joint}"], fast, [0.05, 0.05, 0.5]) == pytest.approx(plain)


def test_a_tilted_base_leaves_the_rods_hanging_along_gravity():
    along = [math.pi + 0.1, math.pi + 0.1, 0.0, 0.0]
    a1, m2_l2, g = COEFFICIENTS[2], COEFFICIENTS[5], COEFFICIENTS[6]
    upright = np.array([a1, m2_l2]) * g * np.sin(along[:2])
    assert torque_of(EFFECTS["gravity_tilt.base"], along, [0.1]) + upright == pytest.approx([0.0, 0.0], abs=1e-9)
