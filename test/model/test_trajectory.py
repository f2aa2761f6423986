"""Motions come with their derivatives, for the start, the coefficients and every effect's parameters."""

import numpy as np
import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.constants import COUNT, effect_constants
from cdp_ident.model.effects.effect import Form, TorqueEffect
from cdp_ident.model.parameters import SYMBOLS, inertia_about_cart, physical_coefficients
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.torques import NO_TORQUES, Torques
from cdp_ident.model.trajectory import accelerations_at, directions, trajectory, trajectory_with_derivatives
from reference import torques
from reference.pendulum import TABLE_3, TABLE_5
from reference.sticking import motion

TORQUES = {effect.key: effect for effect in CATALOGUE if isinstance(effect, TorqueEffect)}
COEFFICIENTS = physical_coefficients(TABLE_5)
A22 = float(inertia_about_cart(np.array([TABLE_5[symbol] for symbol in SYMBOLS]), TABLE_5["L"]))
START = np.array(TABLE_3)
SLOW = np.array([2.2, 2.6, 0.0, 0.0])
"""A start at rest, from which joints with dry friction stop and go on."""
GRID = TimeGrid.over(np.sort(np.random.default_rng(0).uniform(0.0, 1.5, 200)))
"""Samples anywhere between the integrator's steps."""
CART = 0.5 * np.sin(3.0 * GRID.half_step_times())
STEP = 1e-6
BEGIN = 2.0
STICKING = {
    "both": [("coulomb_friction.inner", 0.5), ("coulomb_friction.outer", 0.2)],
    "strongly": [("coulomb_friction.inner", 8.0), ("coulomb_friction.outer", 4.0)],
    "inner stands": [("coulomb_friction.inner", 20.0), ("coulomb_friction.outer", 3.0)],
    "where it rubs": [("unknown_torque.outer.friction_over_angle", *(1.5 + np.sin(np.arange(128) * np.pi / 8)))],
    "stribeck and load": [("stribeck_friction.inner", 1.0, 0.5, 0.4), ("load_friction.outer", 0.02, 2.0)],
    "behind a gear": [("coulomb_friction.outer", 4.0), ("geared_rotor.outer", -0.1)],
    "on a base that swings": [
        ("coulomb_friction.inner", 3.0),
        ("pivot_compliance.base.oscillating", 1e-4, 18.0, 0.1),
    ],
}
"""Effects with which joints stop, stick and break loose within the grid."""

INEXACT = {
    # How the pull's own acceleration depends on the coefficients is left out.
    "pivot_compliance.base": 1e-2,
    # Steps are as short as the speed asks for, so that the error of the motion (1e-7 rad) depends on that, too.
    "stribeck_friction.inner": 5e-3,
    "stribeck_friction.outer": 1e-4,
    "presliding_friction.inner": 2e-4,
    "presliding_friction.outer": 2e-4,
    # One coefficient changes the motion a little only: differences show what the division of steps does to it.
    **{key: 5e-4 for key, effect in TORQUES.items() if effect.curve},
}
"""Tolerance of derivatives that are not those of differences to within the error of differences."""


def typical(effect):
    values = [parameter.typical for parameter in effect.parameters]
    return [values[0], BEGIN + 0.7] if effect.at_an_instant else values


def fitted(effects):
    """Return which effect and parameter each further direction is."""
    return [(e, k) for e, effect in enumerate(effects) for k, p in enumerate(effect.parameters) if not p.fixed]


def laid_out(effects, values, coefficients=COEFFICIENTS):
    constants = effect_constants(coefficients, TABLE_5["L"], 0.4)
    return Torques.of(list(zip(effects, values, strict=True)), constants, fitted(effects))


def motion_and_point(effects, values, start):
    """Return the motion as a function of all that derivatives are taken by, and the point at which they are."""
    states, chosen = len(start), fitted(effects)
    point = np.concatenate([start, COEFFICIENTS, [values[e][k] for e, k in chosen]])

    def motion(point):
        coefficients, moved = point[states : states + 7], [list(each) for each in values]
        for (e, k), value in zip(chosen, point[states + 7 :], strict=True):
            moved[e][k] = value
        return trajectory(coefficients, point[:states], GRID, CART, laid_out(effects, moved, coefficients), BEGIN)

    return motion, point


def whole(start, torques):
    return np.concatenate([start, np.zeros(torques.states - len(start))])


def assert_close(derivative, expected, tolerance):
    assert np.abs(expected).max() > 0
    assert np.abs(derivative - expected).max() < tolerance * np.abs(expected).max()


def assert_derivatives_are_those_of_differences(effects, values, start, tolerance):
    present = laid_out(effects, values)
    start = whole(start, present)
    states, derivatives = trajectory_with_derivatives(COEFFICIENTS, start, GRID, CART, present, BEGIN)
    _, by_start = trajectory_with_derivatives(COEFFICIENTS, start, GRID, CART, present, BEGIN, by_start_only=True)
    np.testing.assert_allclose(by_start, derivatives[..., : present.states], rtol=1e-9, atol=1e-9)
    motion, point = motion_and_point(effects, values, start)
    assert derivatives.shape == (len(GRID.place), present.states, len(point))
    assert derivatives.shape[2] == directions(present)
    here = motion(point)
    np.testing.assert_allclose(states, here, rtol=0, atol=1e-9)
    for direction in range(len(point)):
        # Parameters are of all sizes: a compliance is a hundred thousandth.
        step = STEP if direction < present.states + 7 else STEP * max(abs(point[direction]), 1e-3 * STEP)
        nudge = step * np.eye(len(point))[direction]
        ahead, behind = (motion(point + nudge) - here) / step, (here - motion(point - nudge)) / step
        found = derivatives[:, :, direction]
        # What a joint at rest does goes by the direction in which it is pushed: either side may be the derivative.
        differences = [0.5 * (ahead + behind), ahead, behind]
        sizes = [max(np.abs(difference).max(), 1e-4) for difference in differences]
        away = [np.abs(found - d).max() / size for d, size in zip(differences, sizes, strict=True)]
        assert min(away) < tolerance, f"direction {direction}"


def test_derivatives_by_start_and_coefficients_are_those_of_differences():
    assert_derivatives_are_those_of_differences([], [], START, 1e-6)


@pytest.mark.parametrize("key", TORQUES)
def test_derivatives_with_an_effect_are_those_of_differences(key):
    effect = TORQUES[key]
    assert_derivatives_are_those_of_differences([effect], [typical(effect)], START, INEXACT.get(key, 3e-5))


@pytest.mark.parametrize("start", [START, SLOW], ids=["at speed", "from rest"])
@pytest.mark.parametrize("given", STICKING.values(), ids=STICKING)
def test_derivatives_go_across_where_joints_stop_stick_and_break_loose(given, start):
    effects, values = [TORQUES[key] for key, *_ in given], [each for _, *each in given]
    assert_derivatives_are_those_of_differences(effects, values, start, 1e-3)


@pytest.mark.parametrize("key", [key for key, effect in TORQUES.items() if effect.has_score])
def test_an_effect_of_no_strength_changes_nothing_but_shows_what_a_little_of_it_would(key):
    effect = TORQUES[key]
    values = [v if p.shape or p.fixed else 0.0 for p, v in zip(effect.parameters, typical(effect), strict=True)]
    absent = laid_out([effect], [values])
    states, derivatives = trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART, absent, BEGIN)
    # The integrator's steps need not be the same, its error is below a microradian and ten of them a second.
    np.testing.assert_allclose(states[:, :4], trajectory(COEFFICIENTS, START, GRID, CART), rtol=0, atol=1e-5)
    little = 1e-4 * abs(effect.parameters[0].typical)
    a_little = trajectory(COEFFICIENTS, START, GRID, CART, laid_out([effect], [[little, *values[1:]]]), BEGIN)
    assert_close(derivatives[:, :, absent.states + 7], (a_little - states) / little, 1e-3)


def test_several_effects_act_together():
    keys = ("coulomb_friction.inner", "joint_spring.outer", "gravity_tilt.base", "geared_rotor.outer")
    effects = [TORQUES[key] for key in keys]
    assert_derivatives_are_those_of_differences(effects, [typical(effect) for effect in effects], START, 1e-5)


def test_the_motion_is_the_same_with_and_without_derivatives():
    states, _ = trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART)
    assert np.allclose(states, trajectory(COEFFICIENTS, START, GRID, CART, NO_TORQUES), rtol=0, atol=1e-9)


def test_taking_derivatives_leaves_the_parameters_as_they_were():
    present = laid_out([TORQUES["cogging_torque.outer.5 per turn"]], [[0.1, 0.2, 5.0]])
    before = present.values.copy()
    trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART, present)
    assert np.array_equal(present.values, before)


@pytest.mark.parametrize("key", TORQUES)
def test_a_state_has_as_many_numbers_more_as_an_effect_says(key):
    present = laid_out([TORQUES[key]], [typical(TORQUES[key])])
    assert (TORQUES[key].states == 2) == (TORQUES[key].form is Form.BASE)
    expected = 4 + TORQUES[key].states
    assert present.states == expected
    assert trajectory(COEFFICIENTS, START, GRID, CART, present).shape == (len(GRID.place), expected)


def test_a_base_whose_state_is_left_out_begins_at_rest():
    effect = TORQUES["pivot_compliance.base.oscillating"]
    present = laid_out([effect], [typical(effect)])
    np.testing.assert_array_equal(
        trajectory(COEFFICIENTS, START, GRID, CART, present),
        trajectory(COEFFICIENTS, np.array([*START, 0.0, 0.0]), GRID, CART, present),
    )


def test_an_effect_s_own_states_are_where_the_layout_puts_them():
    effect = TORQUES["pivot_compliance.base.oscillating"]
    dry = TORQUES["coulomb_friction.outer"]
    first = laid_out([effect, dry], [typical(effect), typical(dry)])
    # Two bases at a time cannot move: the later one does, behind the other's states, which stay as they are.
    second = laid_out([effect, dry, effect], [typical(effect), typical(dry), typical(effect)])
    assert (first.states, second.states) == (6, 8)
    alone, by_alone = trajectory_with_derivatives(COEFFICIENTS, np.array([*START, 1e-3, 0.01]), GRID, CART, first)
    behind, by_behind = trajectory_with_derivatives(
        COEFFICIENTS, np.array([*START, 0.0, 0.0, 1e-3, 0.01]), GRID, CART, second
    )
    own = [0, 1, 2, 3, 6, 7]
    np.testing.assert_allclose(behind[:, own], alone, rtol=0, atol=1e-10)
    assert np.all(behind[:, 4:6] == 0.0)
    of_start_and_coefficients = [*own, *range(8, 15)]
    np.testing.assert_allclose(
        by_behind[:, own][..., of_start_and_coefficients], by_alone[..., :13], rtol=1e-6, atol=1e-8
    )


@pytest.mark.parametrize("joint", ["inner", "outer"])
@pytest.mark.parametrize("give", [5e-4, 1e-3, 0.01, 0.05])
@pytest.mark.parametrize("over", [0.1, 0.6])
def test_friction_that_gives_way_before_it_slips_is_the_reference_s(joint, give, over):
    effect = TORQUES[f"presliding_friction.{joint}"]
    times = np.arange(300) * 0.005
    found = trajectory(
        COEFFICIENTS, SLOW, TimeGrid.over(times), np.zeros(2 * 299 + 1), laid_out([effect], [[over, give]])
    )
    given = torques.dahl(joint, over * A22, over * A22 / give)
    expected = motion(TABLE_5, SLOW, times, torques=[given])
    assert np.abs(found[:, :4] - trajectory(COEFFICIENTS, SLOW, TimeGrid.over(times), np.zeros(599))).max() > 1e-2
    np.testing.assert_allclose(found[:, :2], expected[:, :2], rtol=0, atol=3e-7)
    assert np.all(np.abs(found[:, 4]) <= 1.0 + 1e-9)


@pytest.mark.parametrize("key", ["joint_spring.inner", "coulomb_friction.outer", "geared_rotor.outer"])
def test_accelerations_are_the_slopes_of_the_motion(key):
    present = laid_out([TORQUES[key]], [typical(TORQUES[key])])
    times = np.array([0.0, 1e-5])
    grid = TimeGrid.over(times, 1e-5)
    states = trajectory(COEFFICIENTS, START, grid, np.zeros(3), present)
    found = accelerations_at(COEFFICIENTS, states, np.zeros(2), present)
    expected = (states[1, 2:] - states[0, 2:]) / 1e-5
    np.testing.assert_allclose(found.mean(axis=0), expected, rtol=1e-6)


def test_a_motion_that_becomes_infinite_within_a_step_is_given_up():
    """What moves along with the cart is lighter than the rods, which no cart is: the inertia passes through zero."""
    coefficients = np.array(
        [0.15117463568005213, 0.10626842882317278, 8.983200174583285, 0.3433203943053101, 0.025157550517132414,
         1.2589742355007962, 9.81]
    )  # fmt: skip
    start = np.array(
        [3.8712500602911764, 38.01969678824838, -3.1637829162871043, -2.077637679905242, -0.017786062414330065,
         0.10021555745457902]
    )  # fmt: skip
    grid = TimeGrid.over(np.arange(79) * 0.001688120913358211, 0.001688120913358211)
    effects = [TORQUES["coulomb_friction.inner"], TORQUES["pivot_compliance.base.oscillating"]]
    values = [[0.10093879122293042], [2.161700206447164e-05, 24.402744155425612, 0.0]]
    directions = [(0, 0), (1, 0), (1, 1), (1, 2)]
    torque = Torques.of(list(zip(effects, values, strict=True)), np.zeros(COUNT), directions)
    states, derivatives = trajectory_with_derivatives(coefficients, start, grid, np.zeros(2 * grid.steps + 1), torque)
    assert np.all(np.isfinite(states[:50]))
    assert np.all(np.isnan(states[-1]))
    assert np.all(np.isnan(derivatives[-1]))


def test_a_rod_that_no_step_resolves_is_given_up_from_there_on():
    fast = np.array([1.0, 2.0, -3e5, 1e5])
    for torque in (NO_TORQUES, laid_out([TORQUES["coulomb_friction.outer"]], [[0.2]])):
        states, derivatives = trajectory_with_derivatives(COEFFICIENTS, fast, GRID, CART, torque)
        assert np.all(np.isnan(states))
        assert np.all(np.isnan(derivatives))
    quick = np.array([1.0, 2.0, 20.0, 30.0])
    assert np.all(np.isfinite(trajectory(COEFFICIENTS, quick, GRID, CART)))
