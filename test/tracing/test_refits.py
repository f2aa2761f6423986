"""Refits of a model with other effects."""

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.tracing import refits
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.refits import left_after, refit_with, with_candidates

BY_KEY = {effect.key: effect for effect in CATALOGUE}
DRAG = Candidate(ActiveEffect(BY_KEY["air_drag.inner"]), 0.0, np.array([0.005]))
NOTHING_LEFT = 0.0
"""A squared error that no score test would predict."""


def test_a_refit_that_ends_after_a_few_steps_is_not_repeated_however_little_it_gains(plain, monkeypatch):
    monkeypatch.setattr(refits, "refine_from_afar", lambda *of, **named: pytest.fail("it was fitted again"))
    fit = refit_with(*with_candidates(plain.model, plain.fit.values, [DRAG]), plain.fit, NOTHING_LEFT)
    assert fit.converged
    assert 0.5 * plain.fit.squared_error < fit.squared_error < plain.fit.squared_error


def test_what_cannot_be_computed_over_whole_windows_is_fitted_over_growing_ones(plain, monkeypatch):
    model, values = with_candidates(plain.model, plain.fit.values, [DRAG])
    expected = refit_with(model, values, plain.fit, NOTHING_LEFT)

    def fails(*of, **named):
        raise IdentificationError("it diverged")

    monkeypatch.setattr(refits, "refine", fails)
    grown = refit_with(model, values, plain.fit, NOTHING_LEFT)
    assert grown.squared_error == pytest.approx(expected.squared_error, rel=1e-3)


def test_what_is_left_out_takes_its_values_along(plain):
    spring = Candidate(ActiveEffect(BY_KEY["joint_spring.outer"]), 0.0, np.array([0.1, 0.01]))
    model, values = with_candidates(plain.model, plain.fit.values, [DRAG, spring])
    attempt = refits.Attempt(refits.refine(model, values, plain.fit.windows), plain.folds)
    left, remaining = left_after(attempt, [0])
    assert left.labels == ("joint_spring.outer",)
    assert np.array_equal(remaining[-2:], attempt.fit.values[-2:])
