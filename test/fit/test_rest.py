# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Joints at rest: windows that they begin or end in are followed."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism
from cdp_ident.fit.windows import cut_at, cut_into_windows
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.trial.trial import Trial
from reference.dry_friction import DryFriction
from reference.pendulum import TABLE_5
from reference.sticking import motion
from scenarios.effects import EFFECTS
from scenarios.paper_rig import A22, GROUPS, LENGTH

TIME = np.arange(1600) / 200.0
STEP = 2 * np.pi / 2000


def model_of(effects):
    """Return a model with effects, by their keys, and the true values with theirs."""
    model, values = MotionModel(Mechanism(LENGTH, TABLE_5["g"], LENGTH, A22)), GROUPS
    for key, own in effects.items():
        model = model.with_effect(ActiveEffect(EFFECTS[key]))
        values = np.append(values, own)
    return model, values


def windows_of(states, added):
    """Return the windows of a motion that both encoders show in steps, angles (n, 2) being added to theirs."""
    joints = np.column_stack([states[:, 0], states[:, 1] - states[:, 0]]) + added
    theta = np.cumsum(np.round(joints / STEP) * STEP, axis=1)
    return cut_at(Trial("swing", TIME, theta), 0, list(range(0, 1601, 200)))


def test_the_rounding_of_a_joint_at_rest_is_not_taken_for_its_angle():
    torque, sine, cosine = 0.5, 0.03, -0.04
    states = motion(TABLE_5, (3.9, 4.4, 0.0, 0.0), TIME, DryFriction(torque))
    error = sine * np.sin(states[:, 0]) + cosine * np.cos(states[:, 0])
    windows = windows_of(states, np.column_stack([error, np.zeros(len(TIME))]))
    assert np.any(np.ptp(windows[-1].theta, axis=0) > 20 * STEP)
    assert np.ptp(windows[-1].theta[:, 0]) < 2 * STEP  # the inner joint rests, and the outer one moves
    model, values = model_of({"coulomb_friction.inner": [torque / A22], "encoder_eccentricity.inner": [sine, cosine]})
    fit = fit_initial_states(model, values, windows)
    assert max(np.abs(shown).max() for shown in fit.errors) < 2.0 * STEP
    for window, start in zip(fit.windows[-3:], states[[1000, 1200, 1400]], strict=True):
        assert window.start[0] == pytest.approx(start[0], abs=STEP)


TORQUE = 0.1
ELSEWHERE = 2.5
"""Change of theta2 [rad] to an angle from which the outer rod falls, and from which it is not found again."""
COUNTS = 2 * np.pi / 8000


@pytest.fixture(scope="module")
def begun():
    """Return a model with dry friction in both joints, its values, and the windows of a swing that ends at rest."""
    friction = DryFriction(TORQUE)
    angles = motion(TABLE_5, (3.9, 4.4, 0.0, 0.0), TIME, friction, friction)[:, :2]
    trial = Trial("swing", TIME, np.round(angles / COUNTS) * COUNTS)
    effects = {f"coulomb_friction.{joint}": [TORQUE / A22] for joint in JOINTS}
    return *model_of(effects), cut_into_windows([trial], 1.0)


def test_rods_at_rest_are_found_where_they_are_whatever_the_first_estimate_of_their_speeds(begun):
    model, values, (*others, last) = begun
    assert np.all(np.ptp(last.theta, axis=0) == 0.0)
    last = replace(last, start=np.array([*last.start[:2], 1e-11, -3e-12]))  # as rounding errors of a computer are
    for at_rest in ([last], [*others, last]):
        assert np.abs(fit_initial_states(model, values, at_rest).errors[-1]).max() < 1e-3 * STEP


def test_a_rod_at_rest_is_found_where_it_is(begun):
    model, values, windows = begun
    *others, last = windows
    astray = [*others, replace(last, start=last.start + np.array([0.0, ELSEWHERE, 0.0, 0.0]))]
    right = fit_initial_states(model, values, windows)
    assert fit_initial_states(model, values, astray).rmse() < 1.1 * right.rmse()


def test_a_rod_at_rest_that_was_taken_for_moving_is_found_though_noise_hides_most_of_its_error(begun):
    model, values, quiet = begun
    rng, noise = np.random.default_rng(0), 0.012
    windows = [replace(w, theta=w.theta + rng.normal(0.0, noise, w.theta.shape)) for w in quiet]
    right = fit_initial_states(model, values, windows)
    *others, last = windows
    moving = replace(last, start=last.start + np.array([0.0, 0.0, 0.3, 0.9]))
    assert fit_initial_states(model, values, [*others, moving]).rmse() < 1.01 * right.rmse()
