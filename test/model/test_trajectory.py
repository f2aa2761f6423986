"""Motions come with their derivatives, for the start, the coefficients and every effect's parameters."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.constants import effect_constants
from cdp_ident.model.effects.effect import TorqueEffect
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.trajectory import DIRECTIONS, NO_TORQUES, Torques, trajectory, trajectory_with_derivatives
from reference.pendulum import TABLE_3, TABLE_5

TORQUES = {effect.key: effect for effect in CATALOGUE if isinstance(effect, TorqueEffect)}
COEFFICIENTS = physical_coefficients(TABLE_5)
START = np.array(TABLE_3)
CONSTANTS = effect_constants(COEFFICIENTS, TABLE_5["L"], 0.4)
GRID = TimeGrid.over(np.sort(np.random.default_rng(0).uniform(0.0, 1.5, 200)))
"""Samples anywhere between the integrator's steps."""
CART = 0.5 * np.sin(3.0 * GRID.half_step_times())
STEP = 1e-6
BEGIN = 2.0


def typical(effect):
    values = [parameter.typical for parameter in effect.parameters]
    return [values[0], BEGIN + 0.7] if effect.at_an_instant else values


def torques(effect, values):
    fitted = [(0, k) for k, parameter in enumerate(effect.parameters) if not parameter.fixed]
    return Torques.of([(effect, values)], CONSTANTS, fitted)


def central_difference(motion, step=STEP):
    return (motion(step) - motion(-step)) / (2.0 * step)


def assert_close(derivative, expected, tolerance):
    assert np.abs(expected).max() > 0
    assert np.abs(derivative - expected).max() < tolerance * np.abs(expected).max()


@pytest.mark.parametrize("direction", range(DIRECTIONS))
def test_derivatives_by_start_and_coefficients_are_those_of_differences(direction):
    def motion(step):
        point = np.concatenate([START, COEFFICIENTS])
        point[direction] += step
        return trajectory(point[4:], point[:4], GRID, CART)

    _, derivatives = trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART)
    assert_close(derivatives[:, :, direction], central_difference(motion), 1e-6)


@pytest.mark.parametrize("key", TORQUES)
def test_derivatives_with_an_effect_are_those_of_differences(key):
    effect = TORQUES[key]
    values = typical(effect)
    present = torques(effect, values)
    _, derivatives = trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART, present, BEGIN)
    assert derivatives.shape == (len(GRID.weights), 4, DIRECTIONS + len(present.directions))
    for direction in range(derivatives.shape[2]):

        def motion(step, direction=direction):
            point, nudged = np.concatenate([START, COEFFICIENTS]), list(values)
            if direction < DIRECTIONS:
                point[direction] += step
            else:
                nudged[present.directions[direction - DIRECTIONS, 1]] += step
            return trajectory(point[4:], point[:4], GRID, CART, torques(effect, nudged), BEGIN)

        assert_close(derivatives[:, :, direction], central_difference(motion), 1e-3)


@pytest.mark.parametrize("key", TORQUES)
def test_an_effect_of_no_strength_changes_nothing_but_shows_what_a_little_of_it_would(key):
    effect = TORQUES[key]
    values = typical(effect)
    values = [v if p.shape or p.fixed else 0.0 for p, v in zip(effect.parameters, values, strict=True)]
    absent = torques(effect, values)
    states, derivatives = trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART, absent, BEGIN)
    assert np.allclose(states, trajectory(COEFFICIENTS, START, GRID, CART), rtol=0, atol=1e-10)
    strength = replace(absent, values=absent.values + STEP * np.eye(3)[0])
    weaker = replace(absent, values=absent.values - STEP * np.eye(3)[0])
    expected = (
        trajectory(COEFFICIENTS, START, GRID, CART, strength, BEGIN)
        - trajectory(COEFFICIENTS, START, GRID, CART, weaker, BEGIN)
    ) / (2 * STEP)
    assert_close(derivatives[:, :, DIRECTIONS], expected, 1e-3)


def test_several_effects_act_together():
    chosen = [TORQUES[key] for key in ("coulomb_friction.inner", "joint_spring.outer", "gravity_tilt.base")]
    directions = [(e, k) for e, effect in enumerate(chosen) for k in range(len(effect.parameters))]
    values = [typical(effect) for effect in chosen]

    def laid_out(values):
        return Torques.of(list(zip(chosen, values, strict=True)), CONSTANTS, directions)

    _, derivatives = trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART, laid_out(values))
    for index, (e, k) in enumerate(directions):

        def motion(step, e=e, k=k):
            nudged = [list(of_effect) for of_effect in values]
            nudged[e][k] += step
            return trajectory(COEFFICIENTS, START, GRID, CART, laid_out(nudged))

        assert_close(derivatives[:, :, DIRECTIONS + index], central_difference(motion), 1e-3)


def test_the_motion_is_the_same_with_and_without_derivatives():
    states, _ = trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART)
    assert np.allclose(states, trajectory(COEFFICIENTS, START, GRID, CART, NO_TORQUES), rtol=0, atol=1e-9)


def test_taking_derivatives_leaves_the_parameters_as_they_were():
    present = torques(TORQUES["cogging_torque.outer.5 per turn"], [0.1, 0.2, 5.0])
    before = present.values.copy()
    trajectory_with_derivatives(COEFFICIENTS, START, GRID, CART, present)
    assert np.array_equal(present.values, before)
