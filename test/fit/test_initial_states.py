# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Initial states fitted alone, each window for itself."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5
from scenarios.effects import EFFECTS
from scenarios.paper_rig import A22, LENGTH
from scenarios.paper_rig import GROUPS as TRUTH
from scenarios.twin import TEN_SECONDS, standard_twin, twin

MODEL = MotionModel(Mechanism(LENGTH, TABLE_5["g"], LENGTH, A22))
NOISE = 2.1e-3


@pytest.fixture(scope="module")
def windows():
    return cut_into_windows([standard_twin(np.random.default_rng(0))], 1.0)


@pytest.fixture(scope="module")
def followed(windows):
    return fit_initial_states(MODEL, TRUTH, windows)


def test_the_values_are_held_and_the_initial_states_are_not(windows, followed):
    assert np.array_equal(followed.values, TRUTH)
    assert not np.array_equal(followed.windows[0].start, windows[0].start)
    assert followed.rmse() < NOISE
    again = fit_initial_states(MODEL, TRUTH, followed.windows)
    assert again.rmse() == pytest.approx(followed.rmse(), rel=1e-3)


def test_errors_are_those_of_the_initial_states(followed):
    for window, error in zip(followed.windows, followed.errors, strict=True):
        assert np.array_equal(error, window.theta - MODEL.predict(TRUTH, window.start, window))
    every = np.concatenate(followed.errors)
    assert [followed.rmse(), followed.rmse(0), followed.rmse(1)] == pytest.approx(
        [np.sqrt(np.mean(every**2)), *np.sqrt(np.mean(every**2, axis=0))]
    )


def test_each_is_at_a_minimum_of_its_own_whatever_the_others_and_the_cores(windows, followed, monkeypatch):
    for window, together, residual in zip(windows, followed.windows, followed.errors, strict=True):
        (alone,) = fit_initial_states(MODEL, TRUTH, [window]).windows
        assert np.array_equal(alone.start, together.start)
        slopes = MODEL.motions_in(TRUTH, together.start[None], together, derive=True).by
        slope = np.einsum("nj,njk->k", residual, slopes)
        scale = np.sqrt(np.sum(residual**2) * np.sum(slopes**2, axis=(0, 1)))
        assert np.abs(slope / scale).max() < 1e-3
    monkeypatch.setattr("cdp_ident.machine.parallel.core_count", lambda: 1)
    on_one = fit_initial_states(MODEL, TRUTH, windows)
    assert all(np.array_equal(a, b) for a, b in zip(on_one.errors, followed.errors, strict=True))


def test_a_chaotic_motion_is_followed_from_rough_initial_states():
    start = (np.pi - 2.5, np.pi - 2.9, 16.0, -16.0)
    trial = twin(np.random.default_rng(0), TABLE_5 | {"c1": 0.0, "c2": 0.0}, start)
    found = fit_initial_states(MODEL, TRUTH * [1.0, 1.0, 1.0, 0.0, 0.0], cut_into_windows([trial], 5.0))
    assert found.rmse() < NOISE


def test_samples_far_off_lose_weight(windows, followed):
    theta = windows[2].theta.copy()
    theta[40] += 0.5
    found = fit_initial_states(MODEL, TRUTH, [*windows[:2], replace(windows[2], theta=theta)])
    assert found.windows[2].start == pytest.approx(followed.windows[2].start, abs=0.02)
    assert found.windows[0].start == pytest.approx(followed.windows[0].start, abs=1e-9)


def test_a_window_in_which_nothing_moves_does_no_harm(windows, followed):
    rest = Trial("rest", TEN_SECONDS, np.full((len(TEN_SECONDS), 2), np.pi))
    still = [replace(window, trial=1) for window in cut_into_windows([rest])]
    found = fit_initial_states(MODEL, TRUTH, [*windows, *still])
    moving = [np.sum(error**2) for error in found.errors[: len(windows)]]
    assert moving == pytest.approx([np.sum(error**2) for error in followed.errors])
    assert np.abs(found.errors[-1]).max() < 1e-9


def test_states_that_effects_bring_are_fitted_with_the_rods(windows):
    active = ActiveEffect(EFFECTS["pivot_compliance.base.oscillating"])
    model, values = MODEL.with_effect(active), np.append(TRUTH, [p.typical for p in active.fitted])
    starts = np.array([window.start for window in fit_initial_states(model, values, windows[:3]).windows])
    assert starts.shape == (3, model.states)
    assert np.any(starts[:, 4:])


def test_the_state_of_an_encoder_with_a_mode_of_its_own_is_fitted_however_little_its_unit_says():
    model = MODEL.with_effect(ActiveEffect(EFFECTS["encoder_compliance.inner.oscillating"]))
    values, trial = np.append(TRUTH, [3e-4, 0.05]), standard_twin(np.random.default_rng(0))
    (whole,) = cut_into_windows([trial], 10.0)
    theta = model.predict(values, whole.start, whole)
    followed = fit_initial_states(model, values, cut_into_windows([replace(trial, theta=theta)], 1.25))
    assert followed.rmse() < 1e-6


def test_a_state_that_shows_for_some_samples_is_fitted_though_the_rods_motion_is_chaotic():
    model = MODEL.with_effect(ActiveEffect(EFFECTS["encoder_filter.outer.first order"]))
    values, start = np.append(TRUTH, 7e-3), (np.pi - 2.5, np.pi - 2.9, 16.0, -16.0)
    trial = twin(np.random.default_rng(0), TABLE_5, start)
    (whole,) = cut_into_windows([trial], 10.0)
    theta = model.predict(values, model.initial_state(np.array(start)), whole)
    followed = fit_initial_states(model, values, cut_into_windows([replace(trial, theta=theta)], 10.0))
    assert followed.rmse() < 1e-6


def test_a_state_that_an_effect_brings_stays_near_where_it_can_be_though_the_motion_hardly_shows_it():
    windows = cut_into_windows([standard_twin(np.random.default_rng(0))], 1.25)[:3]
    model, values = (
        MODEL.with_effect(ActiveEffect(EFFECTS["presliding_friction.outer"])),
        np.append(TRUTH, [0.05, 3e-3]),
    )
    assert max(abs(w.start[4]) for w in fit_initial_states(model, values, windows).windows) < 4.0


def test_zeros_of_a_trial_that_the_model_does_not_know_are_fitted_with_its_windows(windows, followed):
    off = [0.03, -0.02]
    shifted = [replace(window, trial=1, theta=window.theta + np.cumsum(off)) for window in windows]
    model, values = MODEL.with_zeros(TRUTH, [0])
    found = fit_initial_states(model, values, [*windows, *shifted])
    assert found.model.zeros == (0, 1)
    assert found.values[found.model.zero_places(1)] == pytest.approx(off, abs=1e-3)
    assert np.array_equal(found.values[found.model.zero_places(0)], [0.0, 0.0])
    assert found.rmse() == pytest.approx(followed.rmse(), rel=1e-3)


def test_no_window_and_one_without_a_motion_are_refused(windows):
    with pytest.raises(IdentificationError, match="nothing to fit: no window of any trial has enough samples"):
        fit_initial_states(MODEL, TRUTH, [])
    with pytest.raises(IdentificationError, match="cannot be computed from the parameters to begin with"):
        fit_initial_states(MODEL, np.full(5, np.nan), windows)


def test_no_guess_of_an_initial_state_matters(windows, followed):
    lost = [replace(window, start=np.array([0.0, 0.0, 1e6, 0.0])) for window in windows]
    found = fit_initial_states(MODEL, TRUTH, lost)
    assert all(np.array_equal(a.start, b.start) for a, b in zip(found.windows, followed.windows, strict=True))
