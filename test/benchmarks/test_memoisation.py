"""While tracing is memoised, nothing is computed twice."""

import numpy as np

from benchmarks._memoisation import memoised
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing import addition, progress, thresholds
from reference.pendulum import TABLE_5
from scenarios.twin import standard_twin

VALUES = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
MODEL = MotionModel(Mechanism.of(Prior()))
FOLDS = ((0, 2), (1, 3))


def test_the_same_refit_and_the_same_predictions_are_computed_once():
    windows = tuple(cut_into_windows([standard_twin(np.random.default_rng(0))]))
    with memoised():
        fit = progress.refine(MODEL, VALUES, windows)
        assert progress.refine(MODEL, VALUES.copy(), list(windows)) is fit
        assert progress.refine(MODEL, 1.01 * VALUES, windows) is not fit
        assert progress.attempt_of(fit, FOLDS) is progress.attempt_of(fit, FOLDS)
    assert progress.refine is refine


def test_what_a_threshold_decides_is_computed_again_with_another_one(monkeypatch):
    fit = progress.refine(MODEL, VALUES, tuple(cut_into_windows([standard_twin(np.random.default_rng(0))])))
    with memoised():
        found = addition.instants(fit)
        assert addition.instants(fit) is found
        monkeypatch.setattr(thresholds, "AWAY", 2 * thresholds.AWAY)
        assert addition.instants(fit) is not found
