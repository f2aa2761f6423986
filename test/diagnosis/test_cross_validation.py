"""Predictions of windows by fits without them."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.cross_validation import cross_validated, error_from_other_trials
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import fit_initial_states, refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from reference.pendulum import TABLE_5
from scenarios.twin import standard_twin

TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
MODEL = MotionModel(Mechanism.of(Prior()))
WINDOWS = cut_into_windows([standard_twin(np.random.default_rng(0))], 1.0)
FOLDS = tuple(tuple(range(first, len(WINDOWS), 4)) for first in range(4))


def test_it_is_what_fits_without_each_fold_predict():
    fit = refine(MODEL, TRUTH, WINDOWS)
    predicted = cross_validated(fit, FOLDS)
    for fold in FOLDS:
        others = refine(MODEL, TRUTH, [w for index, w in enumerate(WINDOWS) if index not in fold])
        left = fit_initial_states(MODEL, others.values, [WINDOWS[index] for index in fold])
        for index, residual in zip(fold, left.residuals, strict=True):
            excess, of_a_fit = (
                np.sum(of**2) - np.sum(fit.residuals[index] ** 2) for of in (predicted.residuals[index], residual)
            )
            assert excess == pytest.approx(of_a_fit, rel=0.25, abs=0.3 * np.sum(residual**2) / np.sqrt(residual.size))
    assert predicted.squared_error > fit.squared_error
    assert np.array_equal(predicted.values, fit.values)


def test_where_the_others_show_values_without_a_motion_those_of_all_windows_predict():
    fit = refine(MODEL, TRUTH, WINDOWS)
    states = MODEL.states
    # Without the first fold, A33 would be negative, and far from it initial states would go along.
    off = [
        residual - (0.0 if index in FOLDS[0] else 1e3) * of[..., states + 1]
        for index, (residual, of) in enumerate(zip(fit.residuals, fit.sensitivities, strict=True))
    ]
    predicted = cross_validated(replace(fit, residuals=tuple(off)), FOLDS)
    for index in FOLDS[0]:
        assert predicted.residuals[index] == pytest.approx(fit.residuals[index], abs=1e-6)


def test_what_only_one_fold_shows_stays_as_it_is_there():
    offset = next(effect for effect in CATALOGUE if effect.key == "encoder_offset.inner")
    fit = refine(MODEL.with_effect(ActiveEffect(offset)), np.append(TRUTH, 0.0), WINDOWS)
    # The first fold's windows alone show the offset, but for a rest of rounding errors.
    shown = [np.array(of) for of in fit.sensitivities]
    for index, of in enumerate(shown):
        of[..., -1] *= 1.0 if index in FOLDS[0] else 1e-9
    predicted = cross_validated(replace(fit, sensitivities=tuple(shown)), FOLDS)
    for index in FOLDS[0]:
        assert np.sum(predicted.residuals[index] ** 2) < 1.1 * np.sum(fit.residuals[index] ** 2)


def test_what_one_window_alone_shows_is_not_predicted_from_the_others():
    """A disturbed window moves the fit towards it; its prediction does not have that."""
    fit = refine(MODEL, TRUTH, WINDOWS)
    wrong = np.where(WINDOWS[3].time > 0.5, 0.02, 0.0)[:, None]
    windows = [*WINDOWS]
    windows[3] = type(windows[3])(**{**vars(windows[3]), "theta": windows[3].theta + wrong})
    disturbed = refine(MODEL, fit.values, windows)
    predicted = cross_validated(disturbed, FOLDS)
    own, others = (np.sum(predicted.residuals[3] ** 2), np.sum(disturbed.residuals[3] ** 2))
    assert own > others


def test_a_strength_that_chance_gives_predicts_nothing():
    """Each of some effects that are not there lowers the fit's error; hardly one lowers that of predictions."""
    plain = refine(MODEL, TRUTH, WINDOWS)
    before = cross_validated(plain, FOLDS).squared_error
    keys = ("joint_spring.inner", "quadratic_friction.outer", "encoder_scale.inner", "gravity_tilt.base")
    gains = []
    for key in keys:
        effect = next(effect for effect in CATALOGUE if effect.key == key)
        model = MODEL.with_effect(ActiveEffect(effect))
        begin = np.concatenate([plain.values, [p.typical * 1e-3 for p in effect.parameters]])
        fit = refine(model, begin, WINDOWS)
        assert fit.squared_error < plain.squared_error * (1 + 1e-6)
        gains.append(before - cross_validated(fit, FOLDS).squared_error)
    assert sum(gains) < 0


def test_a_trial_is_predicted_from_the_others_alone():
    windows = cut_into_windows([standard_twin(np.random.default_rng(seed)) for seed in (0, 1)], 2.0)
    fit = refine(MODEL, TRUTH, windows)
    squared, samples = 0.0, 0
    for trial in (0, 1):
        own, others = ([w for w in windows if (w.trial == trial) is is_own] for is_own in (True, False))
        left = fit_initial_states(MODEL, refine(MODEL, TRUTH, others).values, own)
        squared, samples = squared + left.squared_error, samples + left.samples
    assert error_from_other_trials(fit) == pytest.approx(np.sqrt(squared / samples), rel=1e-3)
    assert error_from_other_trials(fit) > fit.rmse()
