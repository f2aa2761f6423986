# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far ahead a model predicts."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.prediction import Plan, Start, plan_of, predicted
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.scales import scales_of
from cdp_ident.fit.windows import cut_at, cut_into_windows
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5, motion
from scenarios.next_swing import MODEL, PRIOR, TRUTH
from scenarios.twin import TEN_SECONDS, standard_motion, standard_twin

NOISE = np.full(2, 2e-3)
EXACT = Trial("exact", TEN_SECONDS, standard_motion())


def start(trial, first, at, end):
    """Return a start whose state is fitted to samples from the first on, and whose prediction begins at another one."""
    return Start(*(cut_at(trial, 0, [first, until])[0] for until in (at, end)))


def data_of(trials, held_out=()):
    windows = cut_into_windows(trials)
    fit = tuple(window for window in windows if window.trial not in held_out)
    holdout = tuple(window for window in windows if window.trial in held_out) or fit[1:2]
    scales = scales_of(trials, PRIOR.length, PRIOR.gravity)
    return Data(tuple(trials), tuple(trials), fit, holdout, NOISE, 2.5, scales)


def prediction_of(trials, plan=None, values=TRUTH):
    data = data_of(trials)
    return predicted(fit_initial_states(MODEL, values, data.fit), plan or plan_of(data))


def test_the_truth_predicts_exact_angles_up_to_the_horizon():
    plan = plan_of(data_of([EXACT]))
    found = prediction_of([EXACT])
    assert len(plan.starts) > 10
    assert found.time[-1] == plan.horizon == pytest.approx(EXACT.duration / 2)
    assert np.max(found.upper) < 1e-3
    assert [(w.limit, w.median, w.longer) for w in found.within] == [(1, plan.horizon, True), (5, plan.horizon, True)]


def test_what_follows_a_start_is_not_told():
    at, changed = 400, 700
    theta = EXACT.theta + np.outer(np.arange(len(TEN_SECONDS)) >= changed, [0.0, np.radians(3)])
    moved = replace(EXACT, theta=theta)
    found = prediction_of([moved], Plan((start(moved, 200, at, 1400),), False, 1.0, 5.0))
    first, second = found.within
    assert first.median == pytest.approx(TEN_SECONDS[changed] - TEN_SECONDS[at - 1], abs=1e-9)
    assert not first.longer
    assert second.longer
    after = found.time > first.median + 0.01
    assert found.median[after] == pytest.approx(np.radians(3), abs=1e-3)


def test_a_wrong_value_is_as_wrong_as_a_simulation_from_the_same_state_is():
    wrong = TABLE_5 | {"g": 1.02 * TABLE_5["g"]}
    at = 400
    data = data_of([EXACT])
    model = MotionModel(replace(MODEL.mechanism, gravity=wrong["g"]))
    plan = Plan((start(EXACT, 384, at, 1400),), False, 0.08, 5.0)
    found = predicted(fit_initial_states(model, TRUTH, data.fit), plan)
    state = motion(TABLE_5, (*_state_at(at - 1),), TEN_SECONDS[: 1400 - at + 1], tolerance=1e-10)[:, :2]
    off = motion(wrong, (*_state_at(at - 1),), TEN_SECONDS[: 1400 - at + 1], tolerance=1e-10)[:, :2]
    error = np.max(np.abs(state - off), axis=1)
    expected = TEN_SECONDS[np.argmax(error > np.radians(5))]
    assert found.within[1].median == pytest.approx(expected, rel=0.15)


def _state_at(place):
    return motion(TABLE_5, TABLE_3, TEN_SECONDS[: place + 1], tolerance=1e-11)[-1, :4]


def test_starts_are_in_the_trials_that_are_held_out_where_there_are_any():
    twins = [standard_twin(np.random.default_rng(seed)) for seed in range(2)]
    plan = plan_of(data_of(twins, held_out={1}))
    assert plan.held_out
    assert {start.seen.trial for start in plan.starts} == {1}
    both = plan_of(data_of(twins))
    assert not both.held_out
    assert {start.seen.trial for start in both.starts} == {0, 1}


def test_no_prediction_goes_over_a_gap():
    kept = np.flatnonzero((TEN_SECONDS < 4) | (TEN_SECONDS > 5))
    trial = Trial("gap", TEN_SECONDS[kept], EXACT.theta[kept], breaks=(int(np.sum(TEN_SECONDS < 4)),))
    places = [start.whole.samples for start in plan_of(data_of([trial])).starts]
    assert places
    assert all(place.stop <= trial.breaks[0] or place.start >= trial.breaks[0] for place in places)


def test_a_boundary_between_roles_is_no_gap():
    parted = replace(EXACT, breaks=(600, 1200))
    places, without = (
        [(start.seen.samples, start.whole.samples) for start in plan_of(data_of([trial])).starts]
        for trial in (parted, EXACT)
    )
    assert places == without


def test_a_trial_that_is_too_short_has_no_prediction():
    short = Trial("short", TEN_SECONDS[:200], EXACT.theta[:200])
    assert plan_of(data_of([short])).starts == ()
    assert prediction_of([short]) is None
