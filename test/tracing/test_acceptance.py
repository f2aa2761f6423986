"""What an effect must bring to be named."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import Fit, refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import SYMBOLS, groups_of, physical_coefficients
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import improves_enough, is_accepted, share_explained
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, as_measured

NOISE = 1e-3
OSCILLATING = next(effect for effect in CATALOGUE if effect.key == "pivot_compliance.base.oscillating")
MODEL = MotionModel(Mechanism(0.4, 9.81, 0.4, 0.05))
(WINDOW,) = cut_into_windows(
    [Trial("slow", np.linspace(0.0, 1.0, 20), np.linspace(0.0, 0.1, 20)[:, None] * [1.0, 3.0])]
)


def attempt(of_fit: float, of_validation: float) -> Attempt:
    """Return a model that leaves given errors, over the noise."""

    def leaving(error: float) -> Fit:
        residuals = np.full((len(WINDOW.theta), 2), error * NOISE)
        return Fit(MODEL, np.zeros(5), (WINDOW,), (residuals,), (), (), 1, 1, True)

    return Attempt(leaving(of_fit), (), leaving(of_validation))


def test_what_an_effect_explains_is_compared_with_what_remains_above_the_noise():
    share = share_explained(attempt(1.5, 1.5), attempt(2.0, 2.0), NOISE)
    assert share == pytest.approx((2.0**2 - 1.5**2) / (1.5**2 - 1.0))


def test_it_may_explain_more_on_validation_windows():
    assert share_explained(attempt(2.0, 1.1), attempt(2.0, 2.0), NOISE) > thresholds.NAMED


@given(st.floats(0.9, 1.0), st.floats(0.9, 1.0))
def test_a_hundredth_of_the_noise_is_not_worth_a_name_even_where_nothing_remains(of_fit, of_validation):
    before = attempt(of_fit * 1.01, of_validation * 1.01)
    assert share_explained(attempt(of_fit, of_validation), before, NOISE) < thresholds.NAMED


@given(st.floats(0.9, 1.02))
def test_half_the_noise_is_worth_a_name_where_nothing_remains(error):
    assert share_explained(attempt(error, error), attempt(error + 0.5, error + 0.5), NOISE) > thresholds.NAMED


def test_what_one_window_alone_predicts_better_is_not_explained():
    def leaving(*errors: float) -> Fit:
        residuals = tuple(np.full((len(WINDOW.theta), 2), error * NOISE) for error in errors)
        return Fit(MODEL, np.zeros(5), (WINDOW,) * len(errors), residuals, (), (), 1, 1, True)

    fitted = leaving(1.2, 1.2, 1.2)
    after = Attempt(fitted, (), leaving(1.2, 1.2, 1.2))
    astray, better = (Attempt(fitted, (), leaving(*of)) for of in ((30.0, 1.2, 1.2), (30.0, 3.0, 3.0)))
    assert share_explained(after, astray, NOISE) == pytest.approx(0.0)
    assert share_explained(after, better, NOISE) == pytest.approx((3.0**2 - 1.2**2) / (1.2**2 - 1.0))


def test_what_gains_nothing_in_the_fit_is_refused_without_predictions(plain):
    after = Attempt(plain.fit, plain.folds)
    assert not is_accepted(plain, after)
    assert not after.is_predicted


@pytest.mark.parametrize(("compliance", "accepted"), [(0.0, False), (1e-6, False), (3e-6, True)])
def test_a_cart_that_oscillates_by_itself_is_not_taken_for_one_that_the_rods_move(compliance, accepted):
    coefficients = physical_coefficients(TABLE_5)
    acting = ActingEffects.of([(OSCILLATING, (compliance, 11.0, 0.02))], 0.4)
    pushed = np.array([np.pi + 0.9, np.pi + 0.5, 0.0, 0.0, 2e-3, 0.0])
    theta = simulate(coefficients, pushed, TEN_SECONDS, effects=acting)[:, :2]
    trial = Trial("swing", TEN_SECONDS, as_measured(theta, np.random.default_rng(3), noise=5e-4))
    windows = cut_into_windows([trial], 1.25)
    folds = tuple(tuple(range(len(windows))[k::4]) for k in range(4))
    model = MotionModel(Mechanism.of(Prior()))
    plain = attempt_of(refine(model, groups_of([TABLE_5[s] for s in SYMBOLS], TABLE_5["L"]), windows), folds)
    values = np.concatenate([plain.fit.values, [1e-6, 11.0, 0.02]])
    oscillating = attempt_of(refine(model.with_effect(ActiveEffect(OSCILLATING)), values, windows), folds)
    assert improves_enough(plain, oscillating)
    assert is_accepted(plain, oscillating) == accepted
