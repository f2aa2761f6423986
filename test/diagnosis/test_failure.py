# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit that does not follow the motion is called failed."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.evaluation import refuse_a_failed_fit
from cdp_ident.errors import FitFailedError
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from reference.pendulum import TABLE_5
from scenarios.twin import standard_twin, twin

NOISE = 2e-3
"""Of the twin [rad]."""
MODEL = MotionModel(Mechanism.of(Prior()))
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
WINDOWS = cut_into_windows([standard_twin(np.random.default_rng(0))])


@pytest.fixture(scope="module")
def fits():
    """With the rig's values, and with those of a rig whose gravity is four times that."""
    wrong = TRUTH * (1.0, 1.0, 4.0, 1.0, 1.0)
    return [fit_initial_states(MODEL, values, WINDOWS) for values in (TRUTH, wrong)]


def test_a_fit_that_follows_the_motion_is_none(fits):
    right, _ = fits
    refuse_a_failed_fit((right, right), NOISE)


@pytest.mark.parametrize(("place", "which"), [(0, "fitted"), (1, "predicted")])
def test_one_that_does_not_is_refused_with_what_to_try(fits, place, which):
    right, wrong = fits
    pair = [right, right]
    pair[place] = wrong
    with pytest.raises(
        FitFailedError, match=rf"of {len(WINDOWS)} windows {which} .*\(zero, outer_angle.* shorter window"
    ):
        refuse_a_failed_fit(pair, NOISE)


def test_a_swing_in_which_noise_is_most_of_what_moves_is_followed():
    start, noise = (np.pi + 0.01, np.pi - 0.01, 0.0, 0.0), 9e-3
    windows = cut_into_windows([twin(np.random.default_rng(0), start=start, noise=noise)])
    fit = fit_initial_states(MODEL, TRUTH, windows)
    refuse_a_failed_fit((fit, fit), noise)
    with pytest.raises(FitFailedError):
        refuse_a_failed_fit((fit, fit), 0.1 * noise)


def test_angles_that_are_off_all_the_time_are_no_other_motion():
    right = fit_initial_states(MODEL, TRUTH, WINDOWS)
    fit = replace(right, errors=tuple(error + 0.5 for error in right.errors))
    assert fit.rmse() == pytest.approx(0.5, rel=1e-3)
    refuse_a_failed_fit((fit, fit), NOISE)
