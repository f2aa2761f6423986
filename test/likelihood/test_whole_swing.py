"""Whole swings give values as exact as their noise lets them be, and say what the model lacks."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import most_likely
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.trial.trial import Trial
from reference import pendulum, sticking
from reference.dry_friction import DryFriction
from reference.pendulum import TABLE_2, TABLE_5

MODEL = MotionModel(Mechanism(0.4, 9.81, 0.4, 0.03), penalty_of_errors=1e-8)
UNIT = math.sqrt(0.4 / 9.81)
TRUE, BEGIN = (groups_of(np.array([table[s] for s in SYMBOLS]), 0.4) for table in (TABLE_5, TABLE_2))
TIME = np.arange(0.0, 8.0, 0.005)
NOISE = 2.3e-4


@cache
def motion(start=(1.5, 1.2), hidden=()):
    return pendulum.motion(TABLE_5, np.array([*start, 0.0, 0.0]), TIME)[:, :2]


def trial(angles, rng, noise=NOISE, memory=0.0, time=TIME):
    errors = rng.normal(size=angles.shape)
    for k in range(1, len(errors) if memory else 0):
        errors[k] = memory * errors[k - 1] + math.sqrt(1.0 - memory**2) * errors[k]
    readings = np.column_stack([angles[:, 0], angles[:, 1] - angles[:, 0]]) + noise * errors
    return Trial("swing", time, np.cumsum(readings, axis=1))


def found_in(trials, model=MODEL, values=BEGIN):
    def swings_with(spacing):
        swings = [s for k, one in enumerate(trials) for s in Swing.of(one, k, 0.005, spacing, 0.05, np.zeros(2))]
        return swings, [swing.states(model, values, []) for swing in swings]

    return most_likely(model, values, swings_with, np.full(2, 3e-4), UNIT)


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_values_are_as_far_off_as_is_said_and_no_torque_is_missing(memory):
    rng = np.random.default_rng(4)
    found = [found_in([trial(motion(), rng, memory=memory)]) for _ in range(12)]
    off = np.array([(of.values - TRUE) / np.sqrt(np.diag(of.covariance)) for of in found])
    assert 0.7 < np.sqrt(np.mean(off**2)) < 1.4
    assert np.abs(off).max() < 4.0
    assert all(np.all(of.noise.torque == 0.0) for of in found)
    encoders = np.mean([of.noise.encoders for of in found], axis=0)
    np.testing.assert_allclose(encoders, NOISE, rtol=0.15 if memory else 0.03)
    np.testing.assert_allclose(np.mean([of.noise.memory for of in found], axis=0), memory, atol=0.05)


def test_a_longer_swing_is_worth_more_than_its_halves():
    half = len(TIME) // 2
    rng = np.random.default_rng(5)
    whole = trial(motion(), rng)
    halves = [
        Trial("half", whole.time[part] - whole.time[part][0], whole.theta[part])
        for part in (slice(0, half), slice(half, None))
    ]
    joined, apart = found_in([whole]), found_in(halves)
    assert np.all(np.diag(joined.covariance) < np.diag(apart.covariance))
    assert np.diag(joined.covariance)[0] < 0.8 * np.diag(apart.covariance)[0]


def test_outliers_and_a_gap_change_little():
    rng = np.random.default_rng(6)
    plain = trial(motion(), rng)
    theta = plain.theta.copy()
    theta[rng.choice(len(theta), 20, replace=False)] += 0.05
    kept = (TIME < 3.0) | (TIME > 3.12)
    with_them = found_in([replace(plain, theta=theta)])
    with_gap = found_in([Trial("gap", TIME[kept], plain.theta[kept])])
    for found in (with_them, with_gap):
        assert np.all(np.abs(found.values - TRUE) < 4.0 * np.sqrt(np.diag(found.covariance)))
        assert np.all(found.noise.torque == 0.0)


def test_unknown_torques_are_as_large_as_they_were():
    """White noise moves the joints: constant for a step of 5 ms each."""
    rng, size, step = np.random.default_rng(7), np.array([0.05, 0.02]), 0.005
    torques = size / math.sqrt(step) * rng.normal(size=(len(TIME), 2))
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
        states.append(solve_ivp(rates, (0.0, step), states[-1], args=(torque,), rtol=1e-8, atol=1e-10).y[:, -1])
    found = found_in([trial(np.array(states)[:, :2], rng)])
    np.testing.assert_allclose(found.noise.torque, size, rtol=0.35)
    np.testing.assert_allclose(found.noise.encoders, NOISE, rtol=0.1)
    assert np.all(np.abs(found.values - TRUE) < 4.0 * np.sqrt(np.diag(found.covariance)))
    spacing = TIME[-1] / len(found.impulses[0])
    between = torques[:-1].cumsum(axis=0) * step
    at = np.minimum(np.round(np.arange(len(found.impulses[0]) + 1) * spacing / step).astype(int), len(between) - 1)
    assert np.corrcoef(found.impulses[0][2:-2, 0], np.diff(between[at], axis=0)[2:-2, 0])[0, 1] > 0.3


def test_dry_friction_that_a_model_lacks_is_missing_in_its_joint_and_nothing_is_missing_with_it():
    angles = sticking.motion(TABLE_5, np.array([1.5, 1.2, 0.0, 0.0]), TIME, outer=DryFriction(0.002))[:, :2]
    measured = trial(angles, np.random.default_rng(8))
    without = found_in([measured])
    assert without.noise.torque[1] > 0.003
    assert without.noise.torque[0] < 0.3 * without.noise.torque[1]
    (friction,) = (effect for effect in CATALOGUE if effect.key == "coulomb_friction.outer")
    with_it = found_in([measured], MODEL.with_effect(ActiveEffect(friction)), np.append(without.values, 0.05))
    assert np.all(with_it.noise.torque == 0.0)
    assert with_it.misfit < without.misfit - 100.0
    assert np.all(np.abs(with_it.values[:5] - TRUE) < 4.0 * np.sqrt(np.diag(with_it.covariance)[:5]))


def test_what_cannot_be_the_motion_of_a_pendulum_is_told():
    rng = np.random.default_rng(9)
    with pytest.raises(IdentificationError, match="motion"):
        found_in([Trial("noise", TIME, np.cumsum(rng.normal(size=(len(TIME), 2)), axis=1))])
