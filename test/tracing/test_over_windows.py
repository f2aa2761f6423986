# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a torque is missing, what a model has more is to explain a share of the error over windows."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.tracing.over_windows import OverWindows
from scenarios.swings import NOISE, known, measured, motion, with_effect

DRY = "coulomb_friction.outer"
MISSING, SHOWN = np.array([False, True]), np.full(2, NOISE)


@pytest.fixture(scope="module")
def windows():
    return cut_into_windows([measured(motion(dry=4e-4), np.random.default_rng(0))], 0.6)


def test_an_effect_that_is_there_explains_what_one_that_is_not_does_not(rubbing, windows):
    over = OverWindows(windows, SHOWN)
    there, not_there = (
        replace(with_effect(rubbing, key, value), is_missing=MISSING)
        for key, value in ((DRY, 5e-3), ("encoder_scale.inner", 1e-4))
    )
    assert over.explains(there, rubbing)
    assert not over.explains(not_there, rubbing)
    # One that has no more is not to leave more; and nothing is asked where no torque is missing.
    assert over.explains(there, not_there)
    assert not over.explains(not_there, there)
    assert not over.explains(replace(rubbing, is_missing=MISSING), there)
    assert over.explains(replace(rubbing, is_missing=MISSING), not_there)
    assert over.explains(replace(not_there, is_missing=np.zeros(2, dtype=bool)), rubbing)


def test_nothing_is_asked_where_noise_alone_is_left_or_there_are_no_windows(rubbing, windows):
    not_there = replace(with_effect(rubbing, "encoder_scale.inner", 1e-4), is_missing=MISSING)
    assert OverWindows(windows, np.ones(2)).explains(not_there, rubbing)
    assert not OverWindows(windows, np.ones(2)).leaves_less(rubbing, not_there)
    assert OverWindows([], SHOWN).explains(not_there, rubbing)


def test_errors_of_time_are_noise_that_no_effect_explains(rubbing, windows):
    not_there = replace(with_effect(rubbing, "encoder_scale.inner", 1e-4), is_missing=MISSING)
    late = replace(rubbing, noise=replace(rubbing.noise, time=0.01))
    assert np.all(late.noise_of_angles(SHOWN) > 10.0 * NOISE)
    assert OverWindows(windows, SHOWN).explains(not_there, late)


def test_a_model_without_a_motion_explains_nothing(rubbing, windows):
    model, lost = rubbing.model.with_effect(ActiveEffect(known(DRY))), np.append(rubbing.values, np.nan)
    without = replace(rubbing, model=model, values=lost, is_missing=MISSING)
    assert not OverWindows(windows, SHOWN).explains(without, rubbing)
