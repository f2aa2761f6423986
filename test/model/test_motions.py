# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motions are the reference's, with nothing but what they were given in them."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import OptionError
from cdp_ident.model.effects.forces import MOTORS
from cdp_ident.model.motions import InitialValueProblem, accelerations_at, motions, simulate
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid
from reference import pendulum
from reference.pendulum import TABLE_2, TABLE_3, TABLE_5, TIME
from reference.strategies import pendulums, starts
from scenarios.driven import FRICTION, NOISE, START, driven_by_motors
from scenarios.effects import EFFECTS, acting
from scenarios.paper_rig import A22, COEFFICIENTS

ON_THE_GRID = np.arange(0, 10.0005, 0.005)
ANYWHERE = np.sort(np.random.default_rng(7).uniform(0, 10, 1500))
SWAYING_CART = 0.1 * sympy.sin(2 * TIME)
A_SECOND = np.linspace(0, 1, 51)


def largest_difference(values, start, times, step, cart=pendulum.AT_REST):
    """Return the largest difference of angles [rad] and of velocities [rad/s] between simulation and reference."""
    u = pendulum.cart_acceleration(cart, TimeGrid.over(times, step).half_step_times())
    simulated = simulate(physical_coefficients(values), np.asarray(start), times, u, step)
    difference = np.abs(simulated - pendulum.motion(values, start, times, cart))
    return difference[:, :2].max(), difference[:, 2:].max()


@pytest.mark.parametrize(
    ("values", "times", "step", "cart", "limit"),
    [
        *((values, times, DEFAULT_STEP, pendulum.AT_REST, 1e-6)
          for values in (TABLE_2, TABLE_5) for times in (ON_THE_GRID, ANYWHERE)),
        *((TABLE_5, times, 0.001, pendulum.AT_REST, 1e-8) for times in (ON_THE_GRID, ANYWHERE)),
        (TABLE_5, ANYWHERE, DEFAULT_STEP, SWAYING_CART, 1e-6),
        (TABLE_5, ANYWHERE, 0.001, SWAYING_CART, 1e-8),
    ],
    ids=str,
)  # fmt: skip
def test_the_papers_motion_is_the_references_and_closer_at_finer_steps(values, times, step, cart, limit):
    angles, velocities = largest_difference(values, TABLE_3, times, step, cart)
    assert angles < limit
    assert velocities < 10.0 * limit


@given(values=pendulums(), start=starts())
def test_any_pendulum_moves_as_in_the_reference(values, start):
    angles, velocities = largest_difference(values, start, A_SECOND, 0.0005)
    assert angles < 1e-7
    assert velocities < 1e-5


def test_the_error_falls_with_the_fourth_power_of_the_step():
    coarse, _ = largest_difference(TABLE_2, TABLE_3, A_SECOND, 0.004)
    fine, _ = largest_difference(TABLE_2, TABLE_3, A_SECOND, 0.002)
    assert 12 < coarse / fine < 24


@given(values=pendulums(), start=starts(), turns=st.tuples(*[st.integers(-20, 20)] * 2))
def test_whole_turns_and_a_mirror_image_change_nothing_else(values, start, turns):
    coefficients, whole = physical_coefficients(values), 2 * np.pi * np.array([*turns, 0, 0])
    moved = simulate(coefficients, start, A_SECOND)
    np.testing.assert_allclose(simulate(coefficients, start + whole, A_SECOND) - whole, moved, atol=1e-8)
    np.testing.assert_allclose(simulate(coefficients, -start, A_SECOND), -moved, atol=1e-9)


def test_the_motion_at_a_time_does_not_depend_on_the_other_times_asked_for_and_begins_at_its_start():
    coefficients, start = physical_coefficients(TABLE_5), np.array(TABLE_3)
    some = ANYWHERE[::7]
    np.testing.assert_array_equal(simulate(coefficients, start, some), simulate(coefficients, start, ANYWHERE)[::7])
    np.testing.assert_array_equal(simulate(coefficients, start, np.array([0.0, 0.0]))[1], start)


GOOD = physical_coefficients(TABLE_2)


@pytest.mark.parametrize(
    ("coefficients", "start", "times", "u", "step", "message"),
    [
        (GOOD[:6], TABLE_3, [0.0, 1.0], None, 0.005, "7 finite coefficients"),
        (GOOD * np.nan, TABLE_3, [0.0, 1.0], None, 0.005, "7 finite coefficients"),
        (GOOD, TABLE_3[:3], [0.0, 1.0], None, 0.005, "start of 4"),
        (GOOD, (np.inf, 0, 0, 0), [0.0, 1.0], None, 0.005, "finite"),
        (GOOD, TABLE_3, [1.0, 0.5], None, 0.005, "must ascend"),  # as in test_time_grid.py
        (GOOD, TABLE_3, [0.0, 1.0], [0.0] * 400, 0.005, "401 half steps"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(coefficients, start, times, u, step, message):
    with pytest.raises(OptionError, match=message):
        simulate(np.asarray(coefficients), np.asarray(start), np.asarray(times), u, step)


TOGETHER = ("stribeck_friction.inner", "load_friction.outer", "geared_rotor.outer", "impulse.inner", "backlash.outer")
KEYS = pytest.mark.parametrize("keys", [(), TOGETHER, ("presliding_friction.inner",)], ids=len)


def window(rng, keys=(), samples=100, step=0.005, start=TABLE_3):
    """A motion that is like no other one: samples anywhere between steps, its own start, cart, pendulum and effects."""
    grid = TimeGrid.over(np.sort(rng.uniform(0.0, 0.01 * samples, samples)), step)
    coefficients = physical_coefficients(TABLE_5) * rng.uniform(0.98, 1.02, 7)
    effects = [
        (key, [p.typical * (1.0 if p.fixed else rng.uniform(0.8, 1.2)) for p in EFFECTS[key].parameters])
        for key in keys
    ]
    return InitialValueProblem(
        coefficients,
        np.array(start) + rng.normal(scale=0.1, size=4),
        grid,
        0.5 * np.sin(rng.uniform(1.0, 5.0) * grid.half_step_times()),
        acting(*effects, fitted=True),
    )


def of_each(found):
    """Return all that was computed of each motion."""
    samples = zip(found.bounds[:-1], found.bounds[1:], strict=True)
    return [
        (found.readings[first:end], found.by[first:end], found.ends[k], found.ends_by[k])
        for k, (first, end) in enumerate(samples)
    ]


def assert_same(found, expected):
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)


@KEYS
def test_the_company_of_a_motion_changes_no_bit_of_it(keys):
    rng = np.random.default_rng(4)
    kinds = ((100, 0.005), (1, 0.005), (30, 0.002), (90, 0.02), (2, 0.01))
    problems = [window(rng, keys, samples, step) for samples, step in kinds]
    together = of_each(motions(problems, derive=True))
    for problem, found in zip(problems, together, strict=True):
        (alone,) = of_each(motions([problem], derive=True))
        assert_same(found, alone)


@KEYS
def test_a_motion_is_the_same_with_and_without_derivatives_and_with_fewer_of_them(keys):
    problem = window(np.random.default_rng(5), keys)
    every, none = motions([problem], derive=True), motions([problem])
    few = motions([replace(problem, effects=problem.effects.without_directions())], derive=True)
    states = problem.effects.states
    assert (every.by.shape[2], few.by.shape[2], none.by.shape[2]) == (problem.effects.directions, states, 0)
    for other in (few, none):
        np.testing.assert_allclose(other.readings, every.readings, rtol=0, atol=1e-10)
    np.testing.assert_allclose(few.by, every.by[..., :states], rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("start", [(3.0, 3.0, 1e5, -1e5), (3.0, np.nan, 0.0, 0.0)], ids=["senseless", "no number"])
@KEYS
def test_a_motion_that_cannot_be_computed_is_no_number_and_costs_no_other_one_its_own(keys, start):
    rng = np.random.default_rng(2)
    good = [window(rng, keys) for _ in range(3)]
    bad = [good[0], replace(good[1], start=np.array(start)), *good[1:]]
    found, expected = of_each(motions(bad, derive=True)), of_each(motions(good, derive=True))
    assert all(np.all(np.isnan(of_bad)) for of_bad in found.pop(1))
    for ours, theirs in zip(found, expected, strict=True):
        assert_same(ours, theirs)


@KEYS
def test_a_motion_that_breaks_off_keeps_what_was_computed(keys):
    problem = window(np.random.default_rng(3), keys)
    # A cart that is pushed away after half of the time turns the rods ever faster.
    halves = problem.grid.half_step_times()
    pushed = motions([replace(problem, u=np.where(halves < 0.5, problem.u, 1e7))], derive=True)
    lost = np.isnan(pushed.readings).all(axis=1)
    assert 0 < lost.sum() < len(lost)
    assert np.all(np.diff(lost.astype(int)) >= 0)
    before = problem.grid.place * problem.grid.step < 0.45
    np.testing.assert_array_equal(pushed.readings[before], motions([problem], derive=True).readings[before])
    assert np.all(np.isnan(pushed.by[lost]))
    assert np.all(np.isnan(pushed.ends))


def test_a_start_is_cut_or_filled_up_with_zeros():
    problem = window(np.random.default_rng(6), ("pivot_compliance.base.oscillating",))
    short, whole = (replace(problem, start=np.append(problem.start, more)) for more in ([], [0.0, 0.0]))
    long = replace(problem, start=np.append(problem.start, [0.0, 0.0, 5.0]))
    assert_same(*(of_each(motions([one]))[0] for one in (short, whole)))
    assert_same(*(of_each(motions([one]))[0] for one in (long, whole)))


def test_states_are_asked_for_in_the_place_of_readings_and_end_where_the_last_step_does():
    problem = window(np.random.default_rng(7), ("encoder_offset.inner", "pivot_compliance.base.oscillating"))
    shown, states = motions([problem], derive=True), motions([problem], derive=True, shown=False)
    assert (len(shown.states), len(states.readings)) == (0, 0)
    assert states.by.shape == (100, 6, problem.effects.directions)
    np.testing.assert_array_equal(shown.ends, states.ends)
    seen = states.states[:, :2] - np.append([[0.0]] * 100, states.states[:, :1], axis=1)
    offset = problem.effects.values[0]
    np.testing.assert_allclose(shown.readings - seen, np.tile([offset, 0.0], (100, 1)), rtol=0, atol=1e-12)
    at_end = replace(problem.grid, place=np.array([float(problem.grid.steps)]))
    np.testing.assert_allclose(motions([replace(problem, grid=at_end)], shown=False).states, states.ends, atol=1e-12)


def test_motors_torques_move_the_rods_as_in_the_reference():
    trial = driven_by_motors(1, lag=0.0)
    grid = TimeGrid.over(trial.time, 0.0025)
    effects = acting((MOTORS, [1.0 / A22, 0.0, 0.0, 0.0]), ("quadratic_friction.outer", [FRICTION / A22]))
    drive = grid.at_half_steps(trial.time, trial.torques)
    problem = InitialValueProblem(COEFFICIENTS, START, grid, effects=effects, drive=drive)
    theta = motions([problem], shown=False).states[:, :2]
    assert np.std(theta - trial.theta) < 2.0 * NOISE
    still = motions([replace(problem, drive=None)], shown=False).states[:, :2]
    assert np.std(still - trial.theta) > 0.1


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
    exact = pendulum.motion(TABLE_5, start, times)
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
    effects = acting(
        ("coulomb_friction.inner", [0.10093879122293042]),
        ("pivot_compliance.base.oscillating", [2.161700206447164e-05, 24.402744155425612, 0.0]),
        fitted=True,
    )
    found = motions([InitialValueProblem(coefficients, start, grid, effects=effects)], derive=True)
    assert np.all(np.isfinite(found.readings[:50]))
    for lost in (found.readings[-1], found.by[-1], found.ends, found.ends_by):
        assert np.all(np.isnan(lost))
