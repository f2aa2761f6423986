# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Joints that come to rest, in fits."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import cut_at
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.trial.trial import Trial
from reference.dry_friction import DryFriction
from reference.pendulum import TABLE_5
from reference.sticking import motion

PHYSICAL = np.array([TABLE_5[symbol] for symbol in SYMBOLS])
INERTIA = float(inertia_about_cart(PHYSICAL, TABLE_5["L"]))
TIME = np.arange(1600) / 200.0
STEP = 2 * np.pi / 2000


def model_of(effects):
    """Return a model with effects, by their keys, and the true values with theirs."""
    model = MotionModel(Mechanism(TABLE_5["L"], TABLE_5["g"], TABLE_5["L"], INERTIA))
    values = groups_of(PHYSICAL, TABLE_5["L"])
    for key, own in effects.items():
        model = model.with_effect(ActiveEffect(next(effect for effect in CATALOGUE if effect.key == key)))
        values = np.append(values, own)
    return model, values


def windows_of(states, added):
    """Return the windows of a motion that both encoders show in steps, angles (n, 2) being added to theirs."""
    joints = np.column_stack([states[:, 0], states[:, 1] - states[:, 0]]) + added
    theta = np.cumsum(np.round(joints / STEP) * STEP, axis=1)
    return cut_at(Trial("swing", TIME, theta), 0, list(range(0, 1601, 200)), 0.005, 0.1, np.full(2, STEP))


def test_the_rounding_of_a_joint_at_rest_is_not_taken_for_its_angle():
    torque, sine, cosine = 0.5, 0.03, -0.04
    states = motion(TABLE_5, (3.9, 4.4, 0.0, 0.0), TIME, DryFriction(torque))
    error = sine * np.sin(states[:, 0]) + cosine * np.cos(states[:, 0])
    windows = windows_of(states, np.column_stack([error, np.zeros(len(TIME))]))
    assert np.any(np.ptp(windows[-1].theta, axis=0) > 20 * STEP)
    assert np.all(windows[-1].counts[:, 0] < 0.1)  # the inner joint rests, and the outer one moves
    model, values = model_of(
        {"coulomb_friction.inner": [torque / INERTIA], "encoder_eccentricity.inner": [sine, cosine]}
    )
    fit = fit_initial_states(model, values, windows)
    assert max(np.abs(shown).max() for shown in fit.errors) < 2.0 * STEP
    for window, start in zip(fit.windows[-3:], states[[1000, 1200, 1400]], strict=True):
        assert window.start[0] == pytest.approx(start[0], abs=STEP)


def test_rods_at_rest_are_found_where_they_are_whatever_the_first_estimate_of_their_speeds():
    torque, offset = 0.1, 0.02
    friction = DryFriction(torque)
    states = motion(TABLE_5, (3.9, 4.4, 0.0, 0.0), TIME, friction, friction)
    windows = windows_of(states, np.tile([0.0, offset], (len(TIME), 1)))
    *others, last = windows
    assert np.all(np.ptp(last.theta, axis=0) == 0.0)
    last = replace(last, start=np.array([*last.start[:2], 1e-11, -3e-12]))  # as rounding errors of a computer are
    model, values = model_of(
        {
            "coulomb_friction.inner": [torque / INERTIA],
            "coulomb_friction.outer": [torque / INERTIA],
            "encoder_offset.outer": [offset],
        }
    )
    for at_rest in ([last], [*others, last]):
        assert np.abs(fit_initial_states(model, values, at_rest).errors[-1]).max() < 1e-3 * STEP
