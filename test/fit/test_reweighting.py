"""Weights of both angles by the errors that a fit leaves."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.reweighting import reweighted, usual_covariance, whitening
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, standard_motion

MODEL = MotionModel(Mechanism.of(Prior()))
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
INNER, OUTER = 1e-3, 5e-4


def covariance_of(fit):
    return usual_covariance(fit, [window.counts for window in fit.windows])


@pytest.fixture(scope="module")
def relative():
    rng = np.random.default_rng(0)
    inner, outer = rng.normal(0, [[INNER], [OUTER]], (2, len(TEN_SECONDS)))
    trial = Trial("relative", TEN_SECONDS, standard_motion() + np.stack([inner, inner + outer], axis=1))
    return refine(MODEL, TRUTH, cut_into_windows([trial]))


def test_readings_that_add_up_are_taken_apart(relative):
    white = reweighted(relative, INNER).windows[0].whitening
    assert white[1, 1] / white[0, 0] == pytest.approx(INNER / OUTER, rel=0.1)
    assert white[1, 0] == pytest.approx(-white[1, 1], rel=0.1)


def test_the_residuals_are_independent_then_and_the_errors_still_those_of_the_angles(relative):
    fit = reweighted(relative, INNER)
    residuals = np.concatenate(fit.residuals)
    assert np.corrcoef(residuals.T)[0, 1] == pytest.approx(0.0, abs=0.05)
    assert np.std(residuals, axis=0)[0] == pytest.approx(np.std(residuals, axis=0)[1], rel=0.05)
    assert [fit.rmse(0), fit.rmse(1)] == pytest.approx([INNER, np.hypot(INNER, OUTER)], rel=0.05)
    assert fit.squared_error < 1.01 * relative.squared_error


def test_what_is_more_than_noise_has_no_weights(relative):
    assert reweighted(relative, INNER / 2) is relative


def test_weights_that_are_right_stay_as_they_are(relative):
    fit = reweighted(relative, INNER)
    assert reweighted(fit, INNER) is fit


def test_what_happened_in_one_window_has_no_part_in_the_weights(relative):
    residuals = list(relative.residuals)
    residuals[1] = residuals[1] + [0.5, -0.5]
    assert covariance_of(replace(relative, residuals=tuple(residuals)))[0, 1] == pytest.approx(INNER**2, rel=0.2)


def test_rods_at_rest_show_no_noise_and_have_no_part_in_the_weights(relative):
    rest = 1e-3 * np.ones_like(relative.residuals[0])
    still = replace(relative.windows[0], sample_weights=np.full(rest.shape, 1.0 / len(rest)))
    at_rest = replace(
        relative,
        windows=(*relative.windows, *4 * [still]),
        residuals=(*relative.residuals, *4 * [rest]),
    )
    assert covariance_of(at_rest) == pytest.approx(covariance_of(relative))
    assert covariance_of(replace(relative, windows=(still,), residuals=(rest,))) == pytest.approx(
        still.angles_of(rest)[:1].T @ still.angles_of(rest)[:1]
    )


@given(st.floats(0.2, 5.0), st.floats(-0.7, 0.7))
def test_whitened_errors_are_independent_and_alike_and_as_large(ratio, correlation):
    covariance = 1e-6 * np.array([[1.0, correlation * ratio], [correlation * ratio, ratio**2]])
    white = whitening(covariance)
    assert white @ covariance @ white.T == pytest.approx(np.trace(covariance) / 2 * np.eye(2), rel=1e-6, abs=1e-15)


def test_no_combination_of_angles_counts_without_end():
    white = whitening(1e-6 * np.array([[1.0, 1.0], [1.0, 1.0 + 1e-8]]))
    assert np.linalg.cond(white) == pytest.approx(10.0)
    assert np.array_equal(whitening(np.zeros((2, 2))), np.eye(2))


def test_errors_of_nothing_leave_a_fit_as_it_is(relative):
    exact = replace(relative, residuals=tuple(np.zeros_like(residual) for residual in relative.residuals))
    assert reweighted(exact, 0.0) is exact


def test_spikes_that_neighbours_do_not_show_change_the_values_no_more_than_their_samples_missing(relative):
    rng = np.random.default_rng(1)
    places = rng.choice(len(TEN_SECONDS), len(TEN_SECONDS) // 100, replace=False)
    joints = np.zeros((len(TEN_SECONDS), 2))
    joints[places, rng.integers(2, size=len(places))] = rng.uniform(4.0, 10.0, len(places)) * rng.choice(
        [-1, 1], len(places)
    )
    theta = np.concatenate([w.theta for w in relative.windows]) + np.cumsum(joints * [INNER, OUTER], axis=1)
    damaged = Trial("damaged", TEN_SECONDS, theta)
    kept = np.setdiff1d(np.arange(len(TEN_SECONDS)), places)
    without = Trial("without them", TEN_SECONDS[kept], theta[kept])
    fits = [reweighted(refine(MODEL, TRUTH, cut_into_windows([trial])), INNER) for trial in (damaged, without)]
    deviation = np.sqrt(np.diag(covariance(fits[1])))
    assert np.all(np.abs(fits[0].values - fits[1].values) < 0.2 * deviation)
    assert fits[0].rmse() == pytest.approx(fits[1].rmse(), rel=0.02)
    assert np.sqrt(np.diag(covariance(fits[0]))) == pytest.approx(deviation, rel=0.1)
    assert np.abs(np.concatenate(fits[0].errors)[places]).max() > 4.0 * OUTER
    assert reweighted(fits[0], INNER) is fits[0]
