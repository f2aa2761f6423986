# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A base that moves is told from torques in the joints: one acceleration drives both rods."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import likelier_maximum
from cdp_ident.likelihood.noise import Noise
from cdp_ident.tracing.missing_torque import MissingTorque
from reference.pendulum import TABLE_5, accelerations, motion
from scenarios.swings import TIME, fitted, measured, recorded

ACCELERATION = 0.3
"""Of the base, root mean square [m/s^2]."""


@pytest.fixture(scope="module")
def shaken():
    """Return the accelerations of a base at `TIME`, and a swing on it that is fitted with torques in both joints."""
    rng = np.random.default_rng(0)
    knots = np.arange(0.0, TIME[-1] + 1.0, 0.1)
    at_knots = ACCELERATION * rng.normal(size=len(knots))

    def rates(time, state):
        u = float(np.interp(time, knots, at_knots))
        return [*state[2:], *accelerations(TABLE_5, state, u)]

    start = [2.0, 3.5, 0.0, 0.0]
    states = solve_ivp(rates, (0.0, TIME[-1]), start, t_eval=TIME, rtol=1e-9, atol=1e-9, max_step=0.02).y.T
    return np.interp(TIME, knots, at_knots), fitted(recorded([measured(states[:, :2], rng)]))


def with_torques(found):
    """Return a swing fitted with unknown torques in both joints."""
    noise = replace(found.noise, of_base=False, torque=np.full(2, found.recorded.large_torque), tails=())
    return GaussNewton(found.model, found.values, found.recorded, found.states, noise).run().found()


def test_one_acceleration_explains_what_torques_in_both_joints_would(shaken):
    _, found = shaken
    torques = with_torques(found)
    assert not torques.noise.of_base
    assert np.all(torques.is_missing)
    moved = likelier_maximum(torques)
    assert moved.base_moves
    assert moved.misfit < torques.misfit - 50.0
    assert not moved.is_missing[1]
    assert np.all(moved.joints_missing)
    # Which values are found is hardly less exact than with a base that rests.
    assert np.sqrt(np.trace(moved.covariance[:5, :5])) < np.sqrt(np.trace(torques.covariance[:5, :5]))


def test_its_acceleration_and_the_torques_by_which_it_acts_are_those_that_were(shaken):
    there, found = shaken
    moved = likelier_maximum(with_torques(found))
    (swing,), (impulses,) = moved.recorded.swings, moved.impulses
    length = moved.model.coefficients(moved.values)[5]
    middles = swing.node_times[:-1] + 0.5 * swing.spacing
    accelerations_found = length * impulses[:-1, 0, 0] / swing.spacing
    assert np.corrcoef(accelerations_found, np.interp(middles, TIME, there))[0, 1] > 0.8
    missing = MissingTorque.of(moved)
    theta1 = missing.angle[:, 0] + np.pi
    a1 = moved.model.coefficients(moved.values)[2]
    expected = missing.torque[:, 1] - a1 * np.cos(theta1) * accelerations_found
    np.testing.assert_allclose(missing.torque[:, 0], expected, atol=1e-9 + 1e-6 * np.abs(expected).max())


def test_torques_in_a_joint_are_no_base_that_moves():
    rng = np.random.default_rng(1)
    knots = np.arange(0.0, TIME[-1] + 1.0, 0.1)
    at_knots = 2e-3 * rng.normal(size=len(knots))

    def torque(time, state):
        of_joint = float(np.interp(time, knots, at_knots))
        return -of_joint, of_joint

    theta = motion(TABLE_5, (2.0, 3.5, 0.0, 0.0), TIME, torque=torque, tolerance=1e-9)[:, :2]
    found = with_torques(fitted(recorded([measured(theta, rng)])))
    assert found.is_missing[1]
    assert not likelier_maximum(found).noise.of_base


def test_noise_of_a_base_that_moves_is_worth_as_much_as_torques_of_the_same_size():
    noise = Noise.white(np.full(2, 1e-3), 0.1)
    assert replace(noise, of_base=True).torque_with_tails == pytest.approx(noise.torque_with_tails)
