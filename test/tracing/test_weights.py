"""What a model lacks in a trial with a weight is given for the rig without."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.model.weights import Weight
from cdp_ident.tracing.instants import instants
from cdp_ident.tracing.torque_residual import torque_residual
from reference.pendulum import TABLE_5
from scenarios.weighted import INERTIA, plain_and_weighted

MODEL = replace(MotionModel(Mechanism.of(Prior())), inertia_free=True)
TRUTH = MODEL.initial_values(groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"]), INERTIA)
HEAVY = Weight("outer", 0.3, 0.3)
"""So that A22 with it is nearly twice A22."""
ON_RODS = (4e-3, 3e-3)
"""Torques on theta1 and theta2 [N m]."""


def true_fit(torque, of_trials=(0, 1)):
    trials = plain_and_weighted(np.random.default_rng(0), HEAVY, torque=torque, noise=1e-5)
    windows = [window for window in cut_into_windows(trials, 1.0) if window.trial in of_trials]
    return refine(MODEL, TRUTH, windows, hold_values=True)


def test_a_missing_torque_is_the_same_in_N_m_with_a_weight_and_without():  # noqa: N802 - a unit
    residual = torque_residual(true_fit(lambda time, state: ON_RODS))
    for trial in range(2):
        torque = INERTIA * np.median(residual.torque[residual.trial == trial], axis=0)
        assert torque == pytest.approx([sum(ON_RODS), ON_RODS[1]], rel=0.15)


def test_an_impulse_on_a_rod_with_a_weight_has_its_size():
    impulse, at, width = 4e-4, 3.45, 0.01

    def push(time, state):
        return impulse * np.exp(-0.5 * ((time - at) / width) ** 2) / (width * np.sqrt(2 * np.pi)), 0.0

    found = next(c for c in instants(true_fit(push, (1,))) if c.active.effect.key == "impulse.inner")
    assert found.active.trial == 1
    assert found.values[0] * INERTIA == pytest.approx(impulse, rel=0.15)
    assert found.values[1] == pytest.approx(at, abs=0.02)
