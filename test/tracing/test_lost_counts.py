# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Counts are lost at a sample, which residuals say at once."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.tracing.lost_counts import with_better_instants
from scenarios.swings import STEP, TIME, known, measured, motion, recorded, with_effect

AT, LOST = 4.0525, 5e-3
"""When [s], between two samples, and how much [rad]."""


@pytest.fixture(scope="module")
def slipped():
    trial = measured(motion(), np.random.default_rng(2))
    return replace(trial, theta=trial.theta + LOST * (TIME > AT)[:, None] * [0.0, 1.0])


def at(clean, slipped, time, trial=0):
    """Return the model with true values, whose counts are lost at a time, near the truth's states."""
    of = recorded([slipped])
    model = clean.model.with_effect(ActiveEffect(known("encoder_slip.outer"), trial=trial))
    values = np.concatenate([clean.values, [LOST, time]])
    linear = [swing.linearised(model, values, states) for swing, states in zip(of.swings, clean.states, strict=True)]
    return replace(clean, model=model, values=values, recorded=of, linear=tuple(linear))


@pytest.mark.parametrize("off", [-6, -2, 3, 8])
def test_they_are_moved_to_where_they_were_lost(clean, slipped, off):
    values = with_better_instants(at(clean, slipped, AT + off * STEP))
    assert values[-1] == pytest.approx(AT, abs=1.01 * STEP)
    np.testing.assert_array_equal(values[:-1], [*clean.values, LOST])


def test_they_stay_where_they_are_right_or_of_another_trial_and_a_model_without_them_has_none(clean, rubbing, slipped):
    assert with_better_instants(at(clean, slipped, AT)) is None
    assert with_better_instants(at(clean, slipped, AT + 6 * STEP, trial=1)) is None
    assert with_better_instants(clean) is None
    assert with_better_instants(with_effect(rubbing, "coulomb_friction.outer", 5e-3)) is None
