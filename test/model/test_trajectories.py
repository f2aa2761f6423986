"""Windows that are simulated side by side have the motions and derivatives that they have one by one."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.constants import effect_constants
from cdp_ident.model.effects.effect import TorqueEffect
from cdp_ident.model.equations import runge_kutta_step
from cdp_ident.model.initial_value_problem import InitialValueProblem
from cdp_ident.model.lane_rows import LANES
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.torques import Torques
from cdp_ident.model.trajectories import trajectories
from cdp_ident.model.trajectory import trajectory_with_derivatives
from reference.pendulum import TABLE_3, TABLE_5

COEFFICIENTS = physical_coefficients(TABLE_5)
CONSTANTS = effect_constants(COEFFICIENTS, TABLE_5["L"], TABLE_5["L"])
START = np.array(TABLE_3)
ROUNDING = 1e-11
"""Of a window's largest state or derivative; the motion itself makes small differences larger."""


def problem(rng, samples=100, step=0.005, start=START):
    """A window that is like no other one: samples anywhere between the steps, its own start, cart and coefficients."""
    grid = TimeGrid.over(np.sort(rng.uniform(0.0, 0.01 * samples, samples)), step)
    return InitialValueProblem(
        COEFFICIENTS * rng.uniform(0.98, 1.02, len(COEFFICIENTS)),
        start + rng.normal(scale=0.1, size=4),
        grid,
        0.5 * np.sin(rng.uniform(1.0, 5.0) * grid.half_step_times()),
    )


def one_by_one(problems, derivatives="all"):
    results = []
    for each in problems:
        states, by_directions = trajectory_with_derivatives(
            each.coefficients, each.start, each.grid, each.u, each.torques, each.begin, of_angles_only=True
        )
        count = {"all": by_directions.shape[2], "start": 4, "none": 0}[derivatives]
        results.append((states, by_directions[..., :count]))
    return results


def assert_same(found, expected):
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        for ours, theirs in zip(one, other, strict=True):
            assert ours.shape == theirs.shape
            np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=ROUNDING * np.nanmax(np.abs(theirs), initial=0.0))


@pytest.fixture(params=["all", "start", "none"])
def derivatives(request):
    return request.param


@pytest.mark.parametrize("count", [1, 2, 3, LANES, 2 * LANES + 1])
def test_windows_side_by_side_are_what_they_are_one_by_one(count, derivatives):
    rng = np.random.default_rng(count)
    problems = [problem(rng) for _ in range(count)]
    assert_same(trajectories(problems, derivatives), one_by_one(problems, derivatives))


def test_windows_may_differ_in_length_and_in_their_steps():
    rng = np.random.default_rng(0)
    problems = [
        problem(rng, samples, step) for samples, step in ((150, 0.005), (1, 0.005), (30, 0.002), (90, 0.02), (2, 0.01))
    ]
    assert_same(trajectories(problems), one_by_one(problems))


def test_steps_are_divided_where_a_window_asks_for_it():
    rng = np.random.default_rng(1)
    at_steps = TimeGrid.over(0.02 * np.arange(1, 31), 0.02)
    still = np.zeros(2 * at_steps.steps + 1)
    problems = [
        replace(problem(rng, start=START + np.array([0.0, 0.0, fast, -fast])), grid=at_steps, u=still)
        for fast in (0.0, 6.0, 9.0, 12.0)
    ]
    found = trajectories(problems)
    assert_same(found, one_by_one(problems))
    state = problems[-1].start
    for _ in range(at_steps.steps):
        state = np.array(runge_kutta_step(*state, at_steps.step, 0.0, 0.0, 0.0, *problems[-1].coefficients))
    assert np.abs(found[-1][0][-1] - state).max() > 1e-5, "no step was divided"


def test_a_motion_that_cannot_be_computed_costs_no_other_window_its_own(derivatives):
    rng = np.random.default_rng(2)
    good = [problem(rng) for _ in range(5)]
    senseless = replace(good[0], start=np.array([3.0, 3.0, 1e5, -1e5]))
    without_number = replace(good[1], start=np.array([3.0, np.nan, 0.0, 0.0]))
    bad = [good[0], senseless, *good[1:3], without_number, *good[3:]]
    found = trajectories(bad, derivatives)
    for index in (1, 4):
        assert np.all(np.isnan(found[index][0]))
        assert np.all(np.isnan(found[index][1]))
    for index, expected in zip((0, 2, 3, 5, 6), trajectories(good, derivatives), strict=True):
        np.testing.assert_array_equal(found[index][0], expected[0])
        np.testing.assert_array_equal(found[index][1], expected[1])


def test_a_motion_that_breaks_off_keeps_what_was_computed():
    rng = np.random.default_rng(3)
    problems = [problem(rng) for _ in range(3)]
    # A cart that is pushed away after half of the window turns the rods ever faster.
    problems[1] = replace(problems[1], u=np.where(np.arange(len(problems[1].u)) < 200, 0.0, 1e7))
    found, expected = trajectories(problems), one_by_one(problems)
    assert 0 < np.sum(np.isnan(expected[1][0])) < expected[1][0].size
    assert_same(found, expected)


def test_the_company_of_a_window_changes_no_bit_of_it():
    rng = np.random.default_rng(4)
    problems = [problem(rng, samples) for samples in (100, 80, 60, 40, 100, 20)]
    order = [3, 0, 5]
    together, others = trajectories(problems), trajectories(problems[:1] * 7)
    for index, found in zip(order, trajectories([problems[k] for k in order]), strict=True):
        np.testing.assert_array_equal(found[0], together[index][0])
        np.testing.assert_array_equal(found[1], together[index][1])
    for found in others:
        np.testing.assert_array_equal(found[1], together[0][1])


TORQUES = {
    effect.key: effect
    for effect in CATALOGUE
    if isinstance(effect, TorqueEffect) and not effect.curve and not effect.brings_states
}
TOGETHER = (
    ("coulomb_friction.inner", "coulomb_friction.outer", "air_drag.outer.strips"),
    ("stribeck_friction.inner", "load_friction.outer", "geared_rotor.outer", "impulse.inner"),
)


def with_effects(rng, keys, stronger=1.0):
    """A window with effects, of which each window has other values; it begins anywhere, or at rest."""
    given = problem(rng, start=START if rng.random() < 0.7 else np.array([np.pi + 0.1, np.pi - 0.2, 0.0, 0.0]))
    effects = []
    for effect in (TORQUES[key] for key in keys):
        strength = stronger if effect.dry else 1.0
        values = [
            p.typical if p.fixed else p.typical * rng.uniform(0.8, 1.2) * (1.0 if p.shape else strength)
            for p in effect.parameters
        ]
        effects.append((effect, [*values[:1], 0.1] if effect.at_an_instant else values))
    directions = [(e, p) for e, key in enumerate(keys) for p, of in enumerate(TORQUES[key].parameters) if not of.fixed]
    constants = effect_constants(given.coefficients, TABLE_5["L"], TABLE_5["L"])
    return replace(given, torques=Torques.of(effects, constants, directions))


@pytest.mark.parametrize("keys", [*((key,) for key in TORQUES), *TOGETHER], ids="+".join)
@pytest.mark.parametrize("stronger", [1.0, 20.0])
def test_effects_act_on_windows_side_by_side_as_on_one_alone(keys, stronger, derivatives):
    rng = np.random.default_rng(5)
    problems = [with_effects(rng, keys, stronger) for _ in range(LANES + 3)]
    found, expected = trajectories(problems, derivatives), one_by_one(problems, derivatives)
    # The derivatives of a base that gives way are differences, which make more of rounding.
    rounding = 1e-7 if "pivot_compliance.base" in keys else 1e-9
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one[0], other[0], rtol=0.0, atol=1e-10)
        np.testing.assert_allclose(one[1], other[1], rtol=0.0, atol=rounding * np.abs(other[1]).max(initial=0.0))


def test_joints_stop_and_break_loose_in_windows_side_by_side():
    rng = np.random.default_rng(6)
    problems = [with_effects(rng, TOGETHER[0], 20.0) for _ in range(LANES)]
    speeds = np.concatenate([states[:, 2] for states, _ in trajectories(problems)])
    assert np.any(speeds == 0.0), "no joint ever stuck"
    assert np.any(np.diff((speeds == 0.0).astype(int)) < 0), "none broke loose"


def test_the_company_of_a_window_with_effects_changes_no_bit_of_it(derivatives):
    rng = np.random.default_rng(7)
    problems = [with_effects(rng, TOGETHER[1], 10.0) for _ in range(2 * LANES + 3)]
    together = trajectories(problems, derivatives)
    some = rng.permutation(len(problems))[: LANES - 2]
    for index, found in zip(some, trajectories([problems[k] for k in some], derivatives), strict=True):
        for ours, theirs in zip(found, together[index], strict=True):
            np.testing.assert_array_equal(ours, theirs)


def test_windows_whose_effects_differ_are_simulated_apart():
    rng = np.random.default_rng(8)
    of_one, of_other = ("coulomb_friction.outer",), ("joint_spring.inner",)
    problems = [with_effects(rng, of_one if k < LANES else of_other) for k in range(2 * LANES)]
    for one, other in zip(trajectories(problems), one_by_one(problems), strict=True):
        np.testing.assert_allclose(one[0], other[0], rtol=0.0, atol=1e-10)
        assert one[1].shape == other[1].shape


def test_curves_and_what_has_states_of_its_own_are_simulated_one_by_one():
    rng = np.random.default_rng(9)
    for key in ("unknown_torque.outer.over_angle", "presliding_friction.inner"):
        effect = next(effect for effect in CATALOGUE if effect.key == key)
        torques = Torques.of([(effect, [p.typical for p in effect.parameters])], CONSTANTS, [(0, 0)])
        problems = [replace(problem(rng), torques=torques) for _ in range(LANES)]
        for one, other in zip(trajectories(problems), one_by_one(problems), strict=True):
            np.testing.assert_array_equal(one[0], other[0])
