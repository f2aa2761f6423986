"""Intervals that hold what they promise."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.bag.diagnostics import ClockRate
from cdp_ident.diagnosis.uncertainty import covariance, reduced_sensitivities, scaled_inverse
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.reweighting import reweighted
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5
from scenarios.twin import TEN_SECONDS, standard_motion, standard_twin
from scenarios.weighted import INERTIA, WEIGHT, plain_and_weighted

MODEL = MotionModel(Mechanism.of(Prior()))
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])


def fit_of(trial):
    return refine(MODEL, TRUTH, cut_into_windows([trial]))


def with_correlated_noise(rng, correlation=0.9, size=2e-3):
    noise = np.zeros((len(TEN_SECONDS), 2))
    for k in range(1, len(noise)):
        noise[k] = correlation * noise[k - 1] + rng.normal(0, size * np.sqrt(1 - correlation**2), 2)
    return Trial("slow noise", TEN_SECONDS, standard_motion() + noise)


def coverage(trials):
    fits = [fit_of(trial) for trial in trials]
    errors = np.array([np.abs(fit.values - TRUTH) / np.sqrt(np.diag(covariance(fit))) for fit in fits])
    return np.mean(errors < 1.96, axis=0)


@pytest.mark.parametrize(
    ("twins", "fewest", "most"), [(40, 0.85, 1.0), pytest.param(300, 0.92, 0.98, marks=pytest.mark.campaign)]
)
def test_intervals_hold_the_truth_as_often_as_they_say(twins, fewest, most):
    held = coverage(standard_twin(np.random.default_rng(20000 + seed)) for seed in range(twins))
    assert np.all((held >= fewest) & (held <= most)), held


@pytest.mark.parametrize(("trials", "fewest"), [(15, 0.8), pytest.param(60, 0.88, marks=pytest.mark.campaign)])
def test_intervals_hold_the_truth_nearly_as_often_where_the_noise_is_correlated(trials, fewest):
    held = coverage(with_correlated_noise(np.random.default_rng(seed)) for seed in range(trials))
    assert np.all(held >= fewest), held


def test_readings_that_add_up_say_more_where_their_noise_is_made_white():
    rng = np.random.default_rng(0)
    inside, narrower = [], []
    for _ in range(10):
        inner, outer = rng.normal(0.0, [[1e-3], [2e-4]], (2, len(TEN_SECONDS)))
        trial = Trial("relative", TEN_SECONDS, standard_motion() + np.stack([inner, inner + outer], axis=1))
        plain = fit_of(trial)
        fit = reweighted(plain, 0.7e-3)
        spread = np.sqrt(np.diag(covariance(fit)))
        inside.append(np.abs(fit.values - TRUTH) < 1.96 * spread)
        narrower.append(spread / np.sqrt(np.diag(covariance(plain))))
        assert fit.rmse(0) == pytest.approx(1e-3, rel=0.1)
    assert np.mean(inside) >= 0.85
    assert np.mean(narrower) < 0.6


def test_correlated_noise_widens_the_intervals():
    white = standard_twin(np.random.default_rng(0))
    slow = with_correlated_noise(np.random.default_rng(0))
    ratio = np.sqrt(np.diag(covariance(fit_of(slow))) / np.diag(covariance(fit_of(white))))
    assert np.all(ratio > 2)


def test_an_uncertain_unit_of_time_counts_by_what_it_changes():
    uncertain = 1e-3
    trial = standard_twin(np.random.default_rng(0))
    sure = fit_of(trial)
    unsure = fit_of(replace(trial, clock=ClockRate(0.0, uncertain)))
    changed = fit_of(replace(trial, time=trial.time * (1.0 + uncertain)))
    added = np.sqrt(np.diag(covariance(unsure)) - np.diag(covariance(sure)))
    assert added == pytest.approx(np.abs(changed.values - sure.values), rel=0.1)


def test_the_units_of_time_of_two_trials_are_uncertain_apart_from_each_other():
    first, second = (standard_twin(np.random.default_rng(seed)) for seed in (0, 1))
    clock = ClockRate(0.0, 1e-2)

    def added(*trials):
        return np.diag(covariance(refine(MODEL, TRUTH, cut_into_windows(trials))))

    one = added(replace(first, clock=clock))
    both = added(replace(first, clock=clock), replace(second, clock=clock))
    assert one / both == pytest.approx(2.0, rel=0.2)


def test_a_window_s_own_start_imitates_a_part_of_what_the_values_do():
    windows = cut_into_windows([standard_twin(np.random.default_rng(0))])
    fit = refine(MODEL, TRUTH, windows)
    for sensitivity, reduced in zip(fit.sensitivities, reduced_sensitivities(fit), strict=True):
        assert (
            np.abs(np.einsum("nrs,nrp->sp", sensitivity[..., :4], reduced)).max()
            < 1e-6 * np.abs(sensitivity).max() ** 2
        )
    known = refine(MODEL, TRUTH, [replace(windows[0], start=np.array(TABLE_3), start_known=True)])
    assert np.array_equal(next(reduced_sensitivities(known)), known.sensitivities[0][..., 4:])


def test_a_value_that_no_window_shows_has_an_infinite_variance_and_leaves_the_others_as_they_are():
    fit = fit_of(standard_twin(np.random.default_rng(0)))
    impulse = next(effect for effect in CATALOGUE if effect.key == "impulse.inner")
    model = MODEL.with_effect(ActiveEffect(impulse, trial=1))
    spread = covariance(refine(model, np.append(fit.values, [0.0, 1.0]), fit.windows))
    assert np.all(np.isinf(np.diag(spread)[5:]))
    assert spread[:5, :5] == pytest.approx(covariance(fit), rel=0.02)


def test_the_covariance_is_symmetric_and_positive():
    spread = covariance(fit_of(standard_twin(np.random.default_rng(0))))
    assert spread == pytest.approx(spread.T)
    scale = 1 / np.sqrt(np.diag(spread))
    assert np.linalg.eigvalsh(spread * np.outer(scale, scale)).min() > 0


def fitted_with(*weights, seed=0):
    """Fit a trial without a weight and one with each of some weights."""
    trials = plain_and_weighted(np.random.default_rng(seed))[:1]
    for index, weight in enumerate(weights):
        _, weighted = plain_and_weighted(np.random.default_rng(seed + index))
        trials.append(replace(weighted, weights=(weight,)))
    errors = tuple(dict.fromkeys(error for weight in weights for error in weight.errors))
    model = replace(MODEL, inertia_free=True, weight_errors=errors, penalty_of_errors=2e-3**2)
    return refine(model, model.initial_values(TRUTH, INERTIA), cut_into_windows(trials))


def std_of(fit):
    return np.sqrt(np.diag(covariance(fit)))


def test_an_uncertain_mass_makes_A22_as_uncertain_and_nothing_else():  # noqa: N802 - a symbol
    exact = replace(WEIGHT, mass_std=0.0, place_std=0.0)
    sure, unsure = std_of(fitted_with(exact)), std_of(fitted_with(replace(exact, mass_std=0.01 * WEIGHT.mass)))
    assert unsure[5] * INERTIA == pytest.approx(0.01, rel=0.02)
    assert unsure[6] == pytest.approx(1.0, rel=0.02)
    assert unsure[:5] == pytest.approx(sure[:5], rel=0.01)


def test_an_uncertain_place_is_found_and_the_groups_are_no_less_certain_than_without_the_trial():
    vague = replace(WEIGHT, mass_std=0.0, place_std=0.02)
    off = fitted_with(replace(vague, place=WEIGHT.place + 0.01))
    assert off.values[6] == pytest.approx(-0.5, abs=0.05)
    assert abs(off.values[5] * INERTIA - 1.0) < 4.0 * std_of(off)[5] * INERTIA < 0.05
    alone = std_of(refine(MODEL, TRUTH, [window for window in off.windows if window.trial == 0]))
    assert np.all(std_of(off)[:5] < 1.05 * alone)


def test_the_same_weight_in_two_trials_has_one_error_and_two_weights_have_two():
    weight = replace(WEIGHT, mass_std=1e-3, place_std=0.0)
    other = replace(weight, mass=weight.mass + 1e-9)
    one, same, two = (std_of(fitted_with(*weights))[5] for weights in ((weight,), (weight, weight), (weight, other)))
    assert same == pytest.approx(one, rel=0.05)
    assert two == pytest.approx(one / np.sqrt(2), rel=0.1)


def test_what_has_no_unknowns_has_an_inverse_of_none():
    inverse, left_out = scaled_inverse(np.empty((0, 0)), 1e-12)
    assert inverse.shape == left_out.shape == (0, 0)
