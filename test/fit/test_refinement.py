"""The refinement finds what made the motion."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.information import curvature, scaled_inverse
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import fit_initial_states, refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import SYMBOLS, groups_of, physical_coefficients
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5, motion
from scenarios.twin import TEN_SECONDS, as_measured, standard_twin

PRIOR = Prior()
MODEL = MotionModel(Mechanism.of(PRIOR))
NOMINAL = MODEL.initial_values(groups_of(PRIOR.centre, PRIOR.length))
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
TWIN = standard_twin(np.random.default_rng(0))
NOISE = 2.1e-3


def covariance(fit):
    return fit.variance * scaled_inverse(curvature(fit), 1e-12)[0]


def deviations(fit):
    return (fit.values - TRUTH) / np.sqrt(np.diag(covariance(fit)))


def frictionless(start, seed=0):
    values = physical_coefficients({**TABLE_5, "c1": 0.0, "c2": 0.0})
    theta = simulate(values, np.array(start), TEN_SECONDS, step=0.001)[:, :2]
    return Trial("frictionless", TEN_SECONDS, as_measured(theta, np.random.default_rng(seed)))


@pytest.mark.parametrize("duration", [1.0, 2.5])
def test_the_true_groups_are_found_from_the_nominal_ones(duration):
    fit = refine(MODEL, NOMINAL, cut_into_windows([TWIN], duration))
    assert fit.converged
    assert np.abs(deviations(fit)).max() < 4
    assert fit.rmse() < NOISE


def test_trials_from_different_starts_are_fitted_jointly():
    second = Trial(
        "second",
        TEN_SECONDS,
        as_measured(
            motion(TABLE_5, (2.2, 2.0, 0.0, 0.0), TEN_SECONDS, tolerance=1e-9)[:, :2], np.random.default_rng(1)
        ),
    )
    fit = refine(MODEL, NOMINAL, cut_into_windows([TWIN, second]))
    assert {window.trial for window in fit.windows} == {0, 1}
    assert np.abs(deviations(fit)).max() < 4
    alone = covariance(refine(MODEL, NOMINAL, cut_into_windows([TWIN])))
    assert np.all(np.diag(covariance(fit)) < np.diag(alone))


def test_a_free_length_is_found():
    model = replace(MODEL, length_std=np.inf)
    begin = np.append(NOMINAL, 0.37)
    fit = refine(model, begin, cut_into_windows([TWIN]))
    assert fit.values[-1] == pytest.approx(0.4, abs=4 * np.sqrt(covariance(fit)[-1, -1]))
    assert np.sqrt(covariance(fit)[-1, -1]) < 2e-3


def test_frictions_are_never_negative_and_zero_where_noise_would_make_them_so():
    fits = [refine(MODEL, NOMINAL, cut_into_windows([frictionless((2.2, 2.0, 0, 0), seed)])) for seed in range(8)]
    frictions = np.array([fit.values[3:] for fit in fits])
    assert np.all(frictions >= 0)
    assert np.any(frictions == 0)
    assert all(fit.rmse() < NOISE for fit in fits)


def test_without_outliers_all_weigh_the_same():
    fit = refine(MODEL, NOMINAL, cut_into_windows([TWIN]))
    assert all(np.all(weight == 1.0) for weight in fit.weights)


def test_a_known_start_stays_and_makes_the_fit_surer():
    windows = cut_into_windows([TWIN])
    known = [replace(windows[0], start=np.array(TABLE_3), start_known=True), *windows[1:]]
    fit = refine(MODEL, NOMINAL, known)
    assert np.array_equal(fit.windows[0].start, TABLE_3)
    assert not np.array_equal(fit.windows[1].start, windows[1].start)
    assert np.abs(deviations(fit)).max() < 4
    without = refine(MODEL, NOMINAL, windows)
    assert np.all(np.diag(covariance(fit)) <= np.diag(covariance(without)))


def test_a_chaotic_motion_is_followed_from_rough_initial_states():
    windows = cut_into_windows([frictionless((np.pi - 2.5, np.pi - 2.9, 16.0, -16.0))], 5.0)
    assert fit_initial_states(MODEL, TRUTH * [1.0, 1.0, 1.0, 0.0, 0.0], windows).rmse() < NOISE


def test_the_same_trials_give_the_same_result_to_the_last_bit():
    first, second = (refine(MODEL, NOMINAL, cut_into_windows([TWIN])) for _ in range(2))
    assert np.array_equal(first.values, second.values)
    assert all(np.array_equal(a, b) for a, b in zip(first.residuals, second.residuals, strict=True))


def test_the_number_of_cores_changes_nothing(monkeypatch):
    windows = cut_into_windows([TWIN])
    several = refine(MODEL, NOMINAL, windows)
    monkeypatch.setattr("cdp_ident.machine.parallel.core_count", lambda: 1)
    assert np.array_equal(refine(MODEL, NOMINAL, windows).values, several.values)


def test_the_fit_s_residuals_are_those_of_its_values_and_starts():
    fit = refine(MODEL, NOMINAL, cut_into_windows([TWIN]))
    for window, residual, sensitivity in zip(fit.windows, fit.residuals, fit.sensitivities, strict=True):
        theta, derivatives = MODEL.predict(fit.values, window.start, window)
        # The last step is so small that the motion is linear in it, and no simulation of its own.
        assert residual == pytest.approx(window.theta - theta, abs=1e-3 * fit.rmse())
        assert sensitivity == pytest.approx(derivatives, abs=1e-5 * np.abs(derivatives).max())
    every = np.concatenate(fit.residuals)
    assert fit.squared_error == pytest.approx(np.sum(every**2))
    assert [fit.rmse(), fit.rmse(0), fit.rmse(1)] == pytest.approx(
        [np.sqrt(np.mean(every**2)), *np.sqrt(np.mean(every**2, axis=0))]
    )


def test_a_fit_can_be_stopped_at_an_error():
    told = []

    def stop(rmse):
        told.append(rmse)
        return rmse < 0.1

    fit = refine(MODEL, NOMINAL, cut_into_windows([TWIN]), stop)
    assert fit.rmse() == pytest.approx(told[-1])
    assert told[-1] < 0.1 < told[-2]
    assert not fit.converged


def test_every_simulation_of_every_stage_is_counted(monkeypatch):
    counted = []
    predict, predict_together = MotionModel.predict, MotionModel.predict_together

    def counting(self, values, start, window, derivatives):
        counted.append(len(window.theta))
        return predict(self, values, start, window, derivatives)

    def counting_each(self, values, starts, windows, derivatives):
        counted.extend(len(window.theta) for window in windows)
        return predict_together(self, values, starts, windows, derivatives)

    monkeypatch.setattr(MotionModel, "predict", counting)
    monkeypatch.setattr(MotionModel, "predict_together", counting_each)
    fit = refine(MODEL, NOMINAL, cut_into_windows([TWIN]))
    assert sum(counted) == fit.simulations * len(TWIN.theta)


def test_values_to_begin_with_are_brought_into_their_limits():
    begin = NOMINAL * [1, 1, 1, 1, -1]
    assert refine(MODEL, begin, cut_into_windows([TWIN])).rmse() < NOISE


@pytest.mark.parametrize("fit", [refine, fit_initial_states])
def test_no_window_is_refused(fit):
    with pytest.raises(IdentificationError, match="nothing to fit: no window of any trial has enough samples"):
        fit(MODEL, NOMINAL, [])


def test_values_without_a_motion_are_refused():
    with pytest.raises(IdentificationError, match="cannot be computed from the parameters to begin with"):
        refine(MODEL, np.full(5, np.nan), cut_into_windows([TWIN]))


def test_the_values_are_held_and_the_initial_states_are_not():
    windows = cut_into_windows([TWIN])
    fit = fit_initial_states(MODEL, TRUTH, windows)
    assert np.array_equal(fit.values, TRUTH)
    assert not np.array_equal(fit.windows[0].start, windows[0].start)
    again = fit_initial_states(MODEL, TRUTH, fit.windows)
    assert np.array_equal(again.values, TRUTH)
    assert again.rmse() == pytest.approx(fit.rmse(), rel=1e-3)


def test_windows_in_which_nothing_moves_do_no_harm():
    rest = Trial("rest", TEN_SECONDS, np.full((len(TEN_SECONDS), 2), np.pi))
    windows = [*cut_into_windows([TWIN]), *(replace(w, trial=1) for w in cut_into_windows([rest]))]
    fit = refine(MODEL, TRUTH, windows)
    assert fit.converged
    assert fit.values == pytest.approx(TRUTH, rel=0.01)


def test_a_state_that_an_effect_brings_stays_near_where_it_can_be_though_the_motion_hardly_shows_it():
    friction = next(effect for effect in CATALOGUE if effect.key == "presliding_friction.outer")
    windows = cut_into_windows([TWIN], 1.25)[:3]
    free = MODEL.with_effect(ActiveEffect(friction))
    known = replace(free, penalty_of_errors=NOISE**2)
    largest = [
        max(
            abs(window.start[4])
            for window in fit_initial_states(model, np.append(TRUTH, [0.05, 3e-3]), windows).windows
        )
        for model in (known, free)
    ]
    assert largest[0] < 4.0
    assert largest[1] > 4.0 * largest[0]
