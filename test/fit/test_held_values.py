"""Initial states fitted alone, each window for itself."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.held_values import fit_each_window
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of, inertia_about_cart
from reference.pendulum import TABLE_5
from scenarios.twin import standard_twin

PHYSICAL = np.array([TABLE_5[symbol] for symbol in SYMBOLS])
GROUPS = groups_of(PHYSICAL, TABLE_5["L"])
MODEL = MotionModel(Mechanism(TABLE_5["L"], TABLE_5["g"], TABLE_5["L"], inertia_about_cart(PHYSICAL, TABLE_5["L"])))
CLOSELY = 1e-9


@pytest.fixture(scope="module")
def windows():
    return cut_into_windows([standard_twin(np.random.default_rng(0))], 1.0)


def test_a_window_s_initial_state_does_not_depend_on_the_others(windows):
    together = fit_each_window(MODEL, GROUPS, windows, CLOSELY)
    assert np.all(together.converged)
    for index, window in enumerate(windows):
        alone = fit_each_window(MODEL, GROUPS, [window], CLOSELY)
        assert alone.starts[0] == pytest.approx(together.starts[index], rel=1e-9, abs=1e-12)
        assert alone.costs[0] == pytest.approx(together.costs[index])


def test_a_window_that_has_converged_is_not_simulated_any_more(windows):
    far = [replace(windows[0], start=windows[0].start + np.array([0.3, -0.3, 1.0, -1.0])), *windows[1:]]
    near, both = (fit_each_window(MODEL, GROUPS, of, CLOSELY) for of in (windows, far))
    assert np.all(both.converged)
    assert both.iterations > near.iterations
    assert both.simulated - near.simulated <= both.iterations


def test_each_is_at_a_minimum_of_its_own(windows):
    fits = fit_each_window(MODEL, GROUPS, windows, CLOSELY)
    for residual, sensitivity, weight in zip(fits.residuals, fits.sensitivities, fits.weights, strict=True):
        slope = np.einsum("nj,njk->k", weight * residual, sensitivity)
        scale = np.sqrt(np.sum(residual**2) * np.sum(sensitivity**2, axis=(0, 1)))
        assert np.abs(slope / scale).max() < 1e-3


def test_known_starts_stay(windows):
    known = [replace(window, start_known=True) for window in windows[:3]]
    fits = fit_each_window(MODEL, GROUPS, known, CLOSELY)
    assert np.array_equal(fits.starts, [window.start for window in known])
    assert np.all(fits.converged)


def test_a_sample_far_off_loses_weight_in_its_window_alone(windows):
    theta = windows[2].theta.copy()
    theta[40] += 0.5
    fits = fit_each_window(MODEL, GROUPS, [*windows[:2], replace(windows[2], theta=theta)], CLOSELY)
    assert fits.weights[2][40].max() < 0.1
    assert [of.min() for of in fits.weights[:2]] == [1.0, 1.0]
    clean = fit_each_window(MODEL, GROUPS, windows[2:3], CLOSELY)
    assert fits.starts[2] == pytest.approx(clean.starts[0], abs=0.02)


def test_states_that_effects_bring_are_fitted_with_the_rods(windows):
    effect = next(e for e in CATALOGUE if e.key == "pivot_compliance.base.oscillating")
    active = ActiveEffect(effect)
    model, values = MODEL.with_effect(active), np.append(GROUPS, [p.typical for p in active.fitted])
    fits = fit_each_window(model, values, windows[:3], CLOSELY)
    assert fits.starts.shape == (3, model.states)
    assert [of.shape[2] for of in fits.sensitivities] == [model.states] * 3
    assert np.any(fits.starts[:, 4:])


def test_a_window_without_a_motion_is_refused(windows):
    lost = replace(windows[1], start=np.array([0.0, 0.0, 1e6, 0.0]))
    with pytest.raises(IdentificationError, match="cannot be computed from the parameters to begin with"):
        fit_each_window(MODEL, GROUPS, [windows[0], lost], CLOSELY)
