"""Torques without a name are accepted by what they predict."""

from types import SimpleNamespace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.stiffness import penalties
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing import unknown_torques
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.tracing.unknown_torques import _exchange_harmonics, _fitted, _predicts_other_trials
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, twin

NOISE = 5e-4
MODEL = MotionModel(Mechanism.of(Prior()))
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
TWO_PER_TURN = next(effect for effect in CATALOGUE if effect.key == "cogging_torque.outer.2 per turn")
CURVE = next(curve for curve in CURVES if curve.key == "unknown_torque.outer.over_angle")


def swing(seed, start, strength):
    def torque(time, state):
        of_joint = strength * np.sin(2.0 * (state[1] - state[0]))
        return -of_joint, of_joint

    rng = np.random.default_rng(seed)
    return twin(rng, start=start, times=TEN_SECONDS[:800], noise=NOISE, torque=torque, tolerance=1e-8)


@pytest.mark.parametrize(("in_the_other", "predicts"), [(4e-3, True), (-4e-3, False)])
def test_a_curve_must_help_in_a_trial_that_it_is_not_fitted_to(in_the_other, predicts):
    trials = [swing(0, (2.2, 2.6, 0.0, 0.0), 4e-3), swing(1, (2.4, 2.2, 0.0, 0.0), in_the_other)]
    windows = cut_into_windows(trials, 1.25)
    folds = tuple(tuple(range(len(windows))[k::4]) for k in range(4))
    plain = refine(MODEL, TRUTH, windows)
    model = MODEL.with_effect(ActiveEffect(CURVE, stiffness=(1e-4,) * len(penalties(CURVE.curve))))
    curved = refine(model, np.concatenate([plain.values, np.zeros(CURVE.curve.count)]), windows)
    assert curved.squared_error < plain.squared_error
    told = []
    progress = Progress(attempt_of(plain, folds), NOISE, told.append)
    assert _predicts_other_trials(progress, attempt_of(curved, folds)) is predicts
    assert ("does not help in the other" in "".join(told)) is not predicts


@pytest.mark.parametrize(("noise", "is_tried"), [(2.0 * NOISE, False), (0.5 * NOISE, True)])
def test_a_curve_is_not_tried_in_the_place_of_a_harmonic_that_leaves_only_noise(noise, is_tried):
    windows = cut_into_windows([swing(0, (2.2, 2.6, 0.0, 0.0), 4e-3)], 1.25)
    folds = tuple(tuple(range(len(windows))[k::2]) for k in range(2))
    plain, harmonic = attempt_of(refine(MODEL, TRUTH, windows), folds), MODEL.with_effect(ActiveEffect(TWO_PER_TURN))
    named = attempt_of(refine(harmonic, np.concatenate([TRUTH, [4e-3, 0.0]]), windows), folds)
    tried = []
    progress = Progress(plain, noise, trying=tried.append)
    progress.current = named
    _exchange_harmonics(progress)
    assert bool(tried) is is_tried
    assert progress.current is named


@pytest.mark.parametrize(("variances", "is_smoothed_again"), [(20.0, True), (4.0, False)])
def test_a_curve_is_as_smooth_as_its_fit_says_where_that_predicts_better_by_more_than_chance(
    variances, is_smoothed_again, monkeypatch
):
    # Of many samples that are mostly noise, what a stiffness gains beyond chance is a small share of the error.
    before, first, second = (
        SimpleNamespace(
            fit=SimpleNamespace(squared_error=error, values=np.zeros(1)),
            validation=SimpleNamespace(rmse=lambda error=error: error),
            model=SimpleNamespace(effects=[ActiveEffect(CURVE)], places=lambda index: slice(0, 1)),
        )
        for error in (2.0, 1.0, 0.999)
    )
    outcomes = iter([[second], []])
    progress = SimpleNamespace(tried=lambda attempt, additions: [(None, first)], replaced=lambda *of: next(outcomes))
    monkeypatch.setattr(unknown_torques, "_smoothed", lambda fit: SimpleNamespace(stiffness=(1.0,)))
    monkeypatch.setattr(unknown_torques, "change", lambda old, new: SimpleNamespace(validation=variances))
    (best,) = _fitted(progress, before, Candidate(ActiveEffect(CURVE), 1.0, np.zeros(1)))
    assert (best is second) is is_smoothed_again
