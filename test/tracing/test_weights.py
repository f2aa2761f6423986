# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a model lacks in a trial with a weight is given for the rig without."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism, Prior
from cdp_ident.likelihood.scores import shocks
from cdp_ident.model.weights import Weight
from cdp_ident.tracing.missing_torque import MissingTorque
from scenarios.paper_rig import GROUPS
from scenarios.swings import fitted, recorded
from scenarios.weighted import INERTIA, plain_and_weighted

MODEL = replace(MotionModel(Mechanism.of(Prior())), inertia_free=True)
TRUTH = MODEL.initial_values(GROUPS, INERTIA)
HEAVY = Weight("outer", 0.3, 0.3)
"""So that A22 with it is nearly twice A22."""
RIPPLE = 6e-3
"""Of a torque in the outer joint over the time [N m]."""


def fit_of(torque, of_trials=(0, 1)):
    trials = plain_and_weighted(np.random.default_rng(0), HEAVY, torque=torque, noise=1e-4)
    of = recorded(trials)
    chosen = replace(of, swings=tuple(swing for swing in of.swings if swing.trial in of_trials))
    return fitted(chosen, MODEL, TRUTH)


def test_a_missing_torque_is_the_same_in_N_m_with_a_weight_and_without():  # noqa: N802 - a unit
    def torque(time, state):
        return -RIPPLE * np.sin(9.0 * time), RIPPLE * np.sin(9.0 * time)

    missing = MissingTorque.of(fit_of(torque))
    sizes = []
    for trial in range(2):
        of = missing.trial == trial
        wave = np.exp(9.0j * missing.time[of])
        sizes.append(2.0 * abs(np.mean(INERTIA * missing.torque[of, 1] * wave)))
    assert sizes == pytest.approx([RIPPLE, RIPPLE], rel=0.15)


def test_an_impulse_on_a_rod_with_a_weight_has_its_size():
    impulse, at, width = 1e-3, 3.45, 0.01

    def push(time, state):
        return impulse * np.exp(-0.5 * ((time - at) / width) ** 2) / (width * np.sqrt(2 * np.pi)), 0.0

    impulses, _ = shocks(fit_of(push, (1,)))
    assert impulses["inner"].trial == 1
    assert impulses["inner"].time == pytest.approx(at, abs=0.04)
    assert impulses["inner"].size * INERTIA == pytest.approx(impulse, rel=0.3)
