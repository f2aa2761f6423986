# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whole swings give values as exact as their noise lets them be, and say what the model lacks."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.likelihood.maxima import most_likely
from cdp_ident.likelihood.recorded import states_of
from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial
from scenarios.swings import BEGIN, MODEL, NOISE, STEP, TIME, TRUE, known, measured, motion, recorded


def found_in(trials, model=MODEL, values=BEGIN):
    def with_nodes(spacing):
        of = recorded(trials, spacing)
        return of, states_of(of, model)

    return most_likely(model, values, with_nodes)


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_values_are_as_far_off_as_is_said_and_no_torque_is_missing(memory):
    rng = np.random.default_rng(4)
    found = [found_in([measured(motion(), rng, memory=memory)]) for _ in range(12)]
    off = np.array([(of.values - TRUE) / np.sqrt(np.diag(of.covariance)) for of in found])
    assert 0.7 < np.sqrt(np.mean(off**2)) < 1.4
    assert np.abs(off).max() < 4.0
    assert all(of.converged and np.all(of.torque == 0.0) for of in found)
    encoders = np.mean([of.noise.encoders for of in found], axis=0)
    np.testing.assert_allclose(encoders, NOISE, rtol=0.15 if memory else 0.03)
    np.testing.assert_allclose(np.mean([of.noise.memory for of in found], axis=0), memory, atol=0.05)


@pytest.mark.parametrize("late", [0.0, 5e-4])
@pytest.mark.parametrize("absolute", [False, True])
def test_noise_is_told_that_is_independent_in_absolute_angles_from_that_of_encoders(absolute, late):
    rng, size = np.random.default_rng(8), np.array([1e-3, 1.5e-3])
    off = rng.normal(size=(len(TIME), 2)) * size
    theta = motion() + (off if absolute else np.cumsum(off, axis=1))
    theta = theta + late * rng.normal(size=(len(TIME), 1)) * np.gradient(theta, TIME, axis=0)
    found = found_in([Trial("seen", TIME, theta)])
    assert found.noise.absolute == absolute
    np.testing.assert_allclose(found.noise.angles(np.array([True, True]))[0], size[0], rtol=0.1)
    shown = found.noise.angles(np.array([True, True])) if absolute else found.noise.encoders
    np.testing.assert_allclose(shown, size, rtol=0.15)
    np.testing.assert_allclose(found.noise.time, late, rtol=0.1)
    assert np.all(np.abs(found.values - TRUE) < 4.0 * np.sqrt(np.diag(found.covariance)))


def test_an_encoder_that_is_late_by_whole_steps_shows_every_sample():
    of = recorded([measured(motion(), np.random.default_rng(9))])
    model, (states,) = MODEL.with_effect(ActiveEffect(known("time_offset.outer"))), states_of(of, MODEL)
    at, beside = (
        of.swings[0].linearised(model, np.append(TRUE, late), states).residuals for late in (4 * STEP, 4 * STEP + 1e-7)
    )
    np.testing.assert_allclose(at, beside, atol=1e-5)


def test_a_longer_swing_is_worth_more_than_its_halves():
    half = len(TIME) // 2
    whole = measured(motion(), np.random.default_rng(5))
    halves = [
        Trial("half", whole.time[part] - whole.time[part][0], whole.theta[part])
        for part in (slice(0, half), slice(half, None))
    ]
    joined, apart = found_in([whole]), found_in(halves)
    assert np.all(np.diag(joined.covariance) < np.diag(apart.covariance))
    assert np.diag(joined.covariance)[0] < 0.8 * np.diag(apart.covariance)[0]


def test_outliers_and_a_gap_change_little():
    rng = np.random.default_rng(6)
    plain = measured(motion(), rng)
    theta = plain.theta.copy()
    theta[rng.choice(len(theta), 20, replace=False)] += 0.05
    kept = (TIME < 3.0) | (TIME > 3.12)
    with_them = found_in([replace(plain, theta=theta)])
    with_gap = found_in([Trial("gap", TIME[kept], plain.theta[kept])])
    for found in (with_them, with_gap):
        assert np.all(np.abs(found.values - TRUE) < 4.0 * np.sqrt(np.diag(found.covariance)))
        assert not np.any(found.is_missing)


def test_unknown_torques_are_as_large_as_they_were():
    """White noise moves the joints: constant for a step of 5 ms each."""
    rng, size = np.random.default_rng(7), np.array([0.02, 0.008])
    torques = size / math.sqrt(STEP) * rng.normal(size=(len(TIME), 2))
    A23, A33, a1, c1, c2 = TRUE
    m2_l2 = A23 / 0.4

    def rates(t, state, torque):
        theta1, theta2, omega1, omega2 = state
        s, c = math.sin(theta1 - theta2), math.cos(theta1 - theta2)
        inner, outer = torque
        first = (
            a1 * 9.81 * math.sin(theta1) - A23 * s * omega2**2 - c1 * omega1 - c2 * (omega1 - omega2) + inner - outer
        )
        second = m2_l2 * 9.81 * math.sin(theta2) + A23 * s * omega1**2 - c2 * (omega2 - omega1) + outer
        return [omega1, omega2, *np.linalg.solve([[1.0, A23 * c], [A23 * c, A33]], [first, second])]

    states = [np.array([1.5, 1.2, 0.0, 0.0])]
    for torque in torques[:-1]:
        states.append(solve_ivp(rates, (0.0, STEP), states[-1], args=(torque,), rtol=1e-8, atol=1e-10).y[:, -1])
    found = found_in([measured(np.array(states)[:, :2], rng)])
    assert np.all(found.is_missing)
    np.testing.assert_allclose(found.noise.torque, size, rtol=0.35)
    np.testing.assert_allclose(found.noise.encoders, NOISE, rtol=0.2)  # which takes what torques do between nodes
    assert np.all(np.abs(found.values - TRUE) < 4.0 * np.sqrt(np.diag(found.covariance)))
    # Each impulse stands for the torque around it, at the end of the stretch after its node.
    swing, (impulses,) = found.recorded.swings[0], found.impulses
    between = np.concatenate([np.zeros((1, 2)), torques.cumsum(axis=0) * STEP])
    begin = np.round((swing.node_times + 0.5 * swing.spacing) / STEP).astype(int)[2:-2]
    true = between[begin + round(swing.spacing / STEP)] - between[begin]
    means, std = impulses[2:-2].transpose(1, 0, 2)
    assert np.corrcoef(means[:, 0], true[:, 0])[0, 1] > 0.3
    assert np.sqrt(np.mean(((means - true) / std) ** 2)) < 1.4


def test_dry_friction_that_a_model_lacks_is_missing_in_its_joint_and_nothing_is_missing_with_it():
    trial = measured(motion(dry=0.002), np.random.default_rng(8))
    without = found_in([trial])
    assert without.is_missing[1]
    assert without.torque[1] > 0.003
    assert without.torque[0] < 0.3 * without.torque[1]
    with_friction = MODEL.with_effect(ActiveEffect(known("coulomb_friction.outer")))
    with_it = found_in([trial], with_friction, np.append(without.values, 0.05))
    assert not np.any(with_it.is_missing)
    assert with_it.misfit < without.misfit - 100.0
    assert np.all(np.abs(with_it.values[:5] - TRUE) < 4.0 * np.sqrt(np.diag(with_it.covariance)[:5]))


def test_a_superfluous_effect_makes_the_model_less_likely():
    trial = measured(motion(), np.random.default_rng(10))
    without = found_in([trial])
    with_spring = MODEL.with_effect(ActiveEffect(known("joint_spring.outer")))
    start = np.concatenate([without.values, np.zeros(len(with_spring.names) - len(without.values))])
    assert found_in([trial], with_spring, start).misfit > without.misfit


def test_what_cannot_be_the_motion_of_a_pendulum_is_told():
    rng = np.random.default_rng(9)
    with pytest.raises(IdentificationError, match="motion"):
        found_in([Trial("noise", TIME[:400], np.cumsum(rng.normal(size=(400, 2)), axis=1))])


@pytest.mark.parametrize(("mass", "place"), [(0.3, 0.3), (0.1, 0.1)])
def test_an_impulse_is_that_of_a_torque_over_the_inertia_without_weights(mass, place):
    """An impulse J in both joints changes the speeds by the inverse of the inertia matrix [kg m^2] times J."""
    trial = replace(measured(motion(), np.random.default_rng(0)), weights=(Weight("outer", mass, place),))
    of = recorded([trial], 0.2)
    (swing,), (states,) = of.swings, states_of(of, MODEL)
    found = swing.linearised(MODEL, TRUE, states)
    ends = states[1:] + found.gaps[:-1]
    inertia = MODEL.mechanism.inertia
    length, (A23, A33) = MODEL.mechanism.length, TRUE[:2]
    for push, (theta1, theta2) in zip(found.pushes[:-1], ends[:, :2], strict=True):
        coupling = (inertia * A23 + mass * length * place) * np.cos(theta1 - theta2)
        matrix = [[inertia + mass * length**2, coupling], [coupling, inertia * A33 + mass * place**2]]
        expected = inertia * np.linalg.solve(matrix, [[1.0, -1.0], [0.0, 1.0]])
        np.testing.assert_allclose(push, expected, rtol=1e-6)
