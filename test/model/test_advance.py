# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motions come with their derivatives, by the start, the coefficients and every effect's parameters."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.motions import InitialValueProblem, motions
from cdp_ident.model.time_grid import TimeGrid
from reference.pendulum import TABLE_3
from scenarios.effects import EFFECTS, typical
from scenarios.paper_rig import COEFFICIENTS

STARTS = {"onwards": [-1.0, 0.2, 4.7, 7.9], "to and fro": list(TABLE_3)}
"""From the first both joints turn on in the same direction, from the second they turn back."""
AT_REST = [2.2, 2.6, 0.0, 0.0]
SAMPLES = np.sort(np.random.default_rng(0).uniform(0.0, 0.8, 60))
"""Anywhere between the integrator's steps [s]."""
BEGIN, INSTANT = 2.0, 2.31
"""When samples begin in the trial, and when happens what does so at an instant [s]."""
DIVIDED = ("stribeck_friction", "presliding_friction")
"""How their steps are divided depends on the motion, and differences would show it: without need, none is."""
INEXACT = {
    "time_offset": 1e-5,
    "unknown_torque": 3e-5,
    "stribeck_friction": 1e-5,
    "presliding_friction": 1e-4,
    "backlash": 3e-4,
    "encoder_compliance": 1e-4,
    "encoder_interpolation": 2e-4,
}
"""Tolerance where derivatives are not those of differences to 3e-6: an angle between steps is a polynomial of its own,
what one coefficient or a shape changes is so little that differences show the error of the motion itself, and of an
error of many periods a turn the phase changes much."""
ROUNDING = 2e-10
"""By so much may the error of a motion change by itself [rad]: where its steps are divided depends on it."""
STICKING = {
    "both": [("coulomb_friction.inner", 0.5), ("coulomb_friction.outer", 0.2)],
    "strongly": [("coulomb_friction.inner", 8.0), ("coulomb_friction.outer", 4.0)],
    "inner stands": [("coulomb_friction.inner", 20.0), ("coulomb_friction.outer", 3.0)],
    "where it rubs": [("unknown_torque.outer.friction_over_angle", *(1.5 + np.sin(np.arange(80) * np.pi / 4)))],
    "stribeck and load": [("stribeck_friction.inner", 1.0, 0.5, 0.4), ("load_friction.outer", 0.02, 2.0)],
    "behind a gear": [("coulomb_friction.outer", 4.0), ("geared_rotor.outer", -0.1)],
    "on a base that swings": [
        ("coulomb_friction.inner", 3.0),
        ("pivot_compliance.base.oscillating", 1e-4, 18.0, 0.1),
    ],
    "on a base that follows": [("coulomb_friction.inner", 3.0), ("pivot_compliance.base", 1e-5)],
}
"""Effects with which joints stop, stick and break loose."""


def problem_of(effects, point, step=0.005, samples=SAMPLES):
    """Return the motion that numbers give: the start, the coefficients, and the parameters of all effects."""
    grid, states = TimeGrid.over(samples, step), 4 + sum(effect.states for effect in effects)
    of_each = np.split(point[states + 7 :], np.cumsum([len(effect.parameters) for effect in effects])[:-1])
    effects = ActingEffects.of(list(zip(effects, of_each, strict=True)) if effects else [], 0.42, fitted=True)
    u = 0.5 * np.sin(5.0 * grid.half_step_times())
    return InitialValueProblem(point[states : states + 7], point[:states], grid, u, effects, BEGIN)


def point_of(effects, values, start):
    own = {1: [0.2], 2: [1e-3, 0.01]}
    return np.concatenate([start, *(own[e.states] for e in effects if e.states), COEFFICIENTS, *values])


def assert_derivatives_are_those_of_differences(effects, values, start, tolerance, one_sided=False, **rest):
    """Compare derivatives of what is shown and of what the motion ends in, by every direction."""
    point = point_of(effects, values, start)
    found = motions([problem_of(effects, point, **rest)], derive=True)
    parameters = [p for effect in effects for p in effect.parameters]
    before = len(point) - len(parameters)
    free = [k for k in range(len(point)) if k < before or not parameters[k - before].fixed]
    assert found.by.shape == (len(SAMPLES), 2, len(free))

    def moved(by):
        there = motions([problem_of(effects, point + by, **rest)])
        return np.concatenate([there.readings.ravel(), there.ends[0]])

    here = moved(0.0)
    # Taking derivatives does not change the motion.
    with_them = np.concatenate([found.readings.ravel(), found.ends[0]])
    np.testing.assert_allclose(with_them, here, rtol=0, atol=1e-9)
    for direction, k in enumerate(free):
        if k >= before and (parameters[k - before].name, effects[-1].name) == ("time", "encoder_slip"):
            assert np.all(found.by[..., direction] == 0.0)  # it is a step, of which no derivative says anything
            continue
        is_time = k >= before and parameters[k - before].name == "time"
        size = (
            1e-6
            if is_time
            else 1e-5 * max(abs(point[k]), 1.0 if k < before - 7 else 0.1)
            if k < before
            else 1e-4 * abs(point[k])
        )
        step = size * np.eye(len(point))[k]
        of_it = np.concatenate([found.by[..., direction].ravel(), found.ends_by[0, :, direction]])
        ahead, behind = moved(step), moved(-step)
        differences = [0.5 * (ahead - behind), *((ahead - here, here - behind) if one_sided else ())]
        # What a joint at rest does goes by the direction in which it is pushed: either side may be the derivative.
        away = [np.abs(of_it * size - by).max() / (tolerance * np.abs(by).max() + ROUNDING) for by in differences]
        assert min(away) < 1.0, f"direction {direction}"


def test_derivatives_of_the_paper_s_motion_are_those_of_differences():
    assert_derivatives_are_those_of_differences([], [], STARTS["to and fro"], 1e-7)


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
@pytest.mark.parametrize("key", EFFECTS)
def test_derivatives_with_an_effect_are_those_of_differences(key, start):
    effect = EFFECTS[key]
    step, tolerance = (0.001 if effect.name in DIVIDED else 0.002), INEXACT.get(effect.name, 3e-6)
    assert_derivatives_are_those_of_differences([effect], [typical(effect, INSTANT)], start, tolerance, step=step)


def test_derivatives_of_several_effects_together_are_those_of_differences():
    keys = (
        "coulomb_friction.inner", "presliding_friction.outer", "joint_spring.outer", "gravity_tilt.base",
        "geared_rotor.outer", "air_drag.outer.strips", "pivot_compliance.base.oscillating", "rod_flex.inner",
        "time_offset.outer", "backlash.outer", "encoder_scale.inner",
    )  # fmt: skip
    effects = [EFFECTS[key] for key in keys]
    values = [typical(effect, INSTANT) for effect in effects]
    values[keys.index("pivot_compliance.base.oscillating")][1] = 30.0
    assert_derivatives_are_those_of_differences(effects, values, STARTS["onwards"], 1e-3, step=0.001)


@pytest.mark.parametrize("start", [STARTS["to and fro"], AT_REST], ids=["at speed", "from rest"])
@pytest.mark.parametrize("given", STICKING.values(), ids=STICKING)
def test_derivatives_go_across_where_joints_stop_stick_and_break_loose(given, start):
    effects, values = [EFFECTS[key] for key, *_ in given], [each for _, *each in given]
    step, samples = 0.001 if effects[0].name in DIVIDED else 0.005, 2.0 * SAMPLES
    assert_derivatives_are_those_of_differences(effects, values, start, 2e-3, True, step=step, samples=samples)


@pytest.mark.parametrize("key", [key for key, effect in EFFECTS.items() if effect.has_score])
def test_an_effect_of_no_strength_changes_nothing_but_has_the_derivatives_of_its_whole_law(key):
    effect = EFFECTS[key]
    absent = [
        v if p.shape or p.fixed else 0.0 for p, v in zip(effect.parameters, typical(effect, INSTANT), strict=True)
    ]
    point = point_of([effect], [absent], STARTS["to and fro"])
    point[4 : 4 + effect.states] = 0.0
    zero, some = (
        problem_of([effect], np.append(point[: -len(absent)], each)) for each in (absent, typical(effect, INSTANT))
    )
    # Beside a motion that has the effect, the law is computed as a whole.
    alone, beside = motions([zero], derive=True), motions([zero, some], derive=True)
    plain = motions([replace(zero, effects=ActingEffects())])
    # The integrator's steps need not be the same: its error is below a microradian.
    np.testing.assert_allclose(alone.readings, plain.readings, rtol=0, atol=1e-6)
    strengths = [4 + effect.states + 7 + k for k, p in enumerate(p for p in effect.parameters if not p.fixed)
                 if not p.shape]  # fmt: skip
    common = [*range(4), *range(4 + effect.states, 4 + effect.states + 7), *strengths]
    whole = beside.by[: len(SAMPLES)][..., common]
    close = 1e-5 * np.abs(whole).max(axis=(0, 1)) + 1e-9
    assert np.all(np.abs(alone.by[..., common] - whole) < close)
    rods = np.abs(alone.ends_by - beside.ends_by[:1])[0, :4][:, common]
    assert np.all(rods < close + 1e-5 * np.abs(beside.ends_by[0, :4][:, common]))
    if effect.moves:
        little = 1e-4 * effect.parameters[0].typical
        change = motions([problem_of([effect], np.append(point[: -len(absent)], [little, *absent[1:]]))]).ends[0, :4]
        expected = (change - alone.ends[0, :4]) / little
        assert np.abs(alone.ends_by[0, :4, strengths[0]] - expected).max() < 2e-3 * np.abs(expected).max()


def test_taking_derivatives_leaves_what_was_given_as_it_was():
    effect = EFFECTS["cogging_torque.outer.5 per turn"]
    problem = problem_of([effect], point_of([effect], [[0.1, 0.2, 5.0]], STARTS["onwards"]))
    given = (problem.coefficients, problem.start, problem.u, problem.effects.values)
    before = [array.copy() for array in given]
    motions([problem], derive=True)
    assert all(np.array_equal(array, old) for array, old in zip(given, before, strict=True))
