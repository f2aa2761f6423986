# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The errors that reports state; a fit that does not follow the motion is called failed."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.evaluation import errors_of, fit_per_cent, free_runs, refuse_a_failed_fit
from cdp_ident.errors import FitFailedError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.windows import FEWEST_SAMPLES, cut_at, cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import groups_of
from cdp_ident.trial.trial import Trial
from scenarios.next_swing import MODEL, PRIOR, TRUTH
from scenarios.twin import TEN_SECONDS, standard_motion, standard_twin, twin

NOMINAL = groups_of(PRIOR.centre, PRIOR.length)
TWIN = standard_twin(np.random.default_rng(0))
WINDOWS = cut_into_windows([TWIN])
NOISE = float(np.sqrt(np.mean((TWIN.theta - standard_motion()) ** 2)))


def errors_over(values, windows, trials=(TWIN,), model=MODEL):
    return errors_with_runs(fit_initial_states(model, values, windows), trials)


def errors_with_runs(fit, trials):
    return errors_of(fit, free_runs(fit, trials, WINDOWS[0].duration), fit.windows)


def test_windows_of_the_fewest_samples_have_errors():
    """Motion that is hardly predictable is cut into such windows."""
    bounds = list(range(0, 10 * FEWEST_SAMPLES, FEWEST_SAMPLES))
    windows = cut_at(TWIN, 0, bounds)
    assert len(windows) == 9
    assert np.isfinite(errors_over(TRUTH, windows).sse_free_run)


def test_the_truth_leaves_the_noise_and_worse_values_more():
    errors, worse = (errors_over(values, WINDOWS) for values in (TRUTH, NOMINAL))
    assert errors.rmse == pytest.approx(NOISE, rel=0.02)
    assert errors.rmse**2 == pytest.approx((errors.rmse_theta1**2 + errors.rmse_theta2**2) / 2)
    # From a start that was estimated from 2.5 s, 10 s of a nearly chaotic motion are followed less well.
    assert NOISE**2 * TWIN.theta.size * 0.9 < errors.sse_free_run < 50 * NOISE**2 * TWIN.theta.size
    assert worse.rmse > 10 * NOISE
    assert worse.sse_free_run > 10


def test_a_trial_whose_whole_motion_cannot_be_computed_leaves_an_infinite_error():
    """What is known of the windows is not lost for that."""
    fit = fit_initial_states(MODEL, TRUTH, WINDOWS)
    senseless = replace(fit, values=np.full_like(TRUTH, 1e150))
    assert errors_with_runs(senseless, [TWIN]) == replace(errors_with_runs(fit, [TWIN]), sse_free_run=np.inf)


def test_free_runs_of_the_windows_asked_for_and_of_trials_add_up():
    alone = errors_over(TRUTH, WINDOWS)
    parts = [errors_over(TRUTH, [window]).sse_free_run for window in WINDOWS]
    assert sum(parts) == pytest.approx(alone.sse_free_run)
    both = errors_over(TRUTH, cut_into_windows([TWIN, TWIN]), [TWIN, TWIN])
    assert both.sse_free_run == pytest.approx(2 * alone.sse_free_run)
    assert both.rmse == pytest.approx(alone.rmse)


def test_a_free_run_of_the_second_trial_has_the_effects_of_the_second_trial():
    slip = next(effect for effect in CATALOGUE if effect.key == "encoder_slip.outer")
    slipped = Trial("slipped", TEN_SECONDS, TWIN.theta + np.outer(TEN_SECONDS >= 4.0, [0.0, 0.3]))
    windows = cut_into_windows([TWIN, slipped])
    model = MODEL.with_effect(ActiveEffect(slip, trial=1))
    with_slip = errors_over(np.append(TRUTH, [0.3, 4.0]), windows, [TWIN, slipped], model)
    without = errors_over(TRUTH, windows, [TWIN, slipped])
    assert with_slip.sse_free_run == pytest.approx(2 * errors_over(TRUTH, WINDOWS).sse_free_run, rel=0.01)
    assert without.sse_free_run > 10 * with_slip.sse_free_run


def test_the_fit_in_per_cent_is_that_of_the_norms_over_all_windows_100_without_error_and_0_for_the_mean():
    fit = fit_initial_states(MODEL, NOMINAL, WINDOWS)
    expected = []
    for column in range(2):
        left = np.concatenate([error[:, column] for error in fit.errors])
        moved = np.concatenate([window.theta[:, column] - np.mean(window.theta[:, column]) for window in WINDOWS])
        expected.append(100 * (1 - np.linalg.norm(left) / np.linalg.norm(moved)))
    assert fit_per_cent(fit) == pytest.approx(expected)
    errors = errors_with_runs(fit, [TWIN])
    assert (errors.fit_theta1, errors.fit_theta2) == pytest.approx(expected)
    means = tuple(window.theta - window.theta.mean(axis=0) for window in fit.windows)
    assert fit_per_cent(replace(fit, errors=means)) == pytest.approx([0, 0])
    assert fit_per_cent(replace(fit, errors=tuple(0 * mean for mean in means))) == pytest.approx([100, 100])


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
