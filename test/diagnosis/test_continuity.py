"""Whether windows join."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.continuity import continuity
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import groups_of
from scenarios.twin import standard_twin

EFFECTS = {effect.key: effect for effect in CATALOGUE}


def fit_of(seed=0, length=0.4, duration=2.5, keep=lambda window: True):
    prior = Prior(nominal={"L": length})
    model = MotionModel(Mechanism.of(prior))
    windows = [w for w in cut_into_windows([standard_twin(np.random.default_rng(seed))], duration) if keep(w)]
    return refine(model, model.initial_values(groups_of(prior.centre, length)), windows)


@pytest.mark.parametrize(("trials", "off"), [(6, 0.4), pytest.param(24, 0.2, marks=pytest.mark.campaign)])
def test_a_true_model_s_windows_join_as_well_as_the_noise_lets_expect(trials, off):
    relative = [continuity(fit_of(seed)).relative for seed in range(trials)]
    # Three boundaries of two angles in each: a root mean square of normal numbers, many of them correlated.
    assert np.sqrt(np.mean(np.square(relative))) == pytest.approx(1.0, abs=off)


def test_windows_of_a_wrong_length_jump():
    found = continuity(fit_of(length=0.42))
    assert found.relative > 5
    assert found.rms > 2e-3
    assert found.boundaries == 3


def test_only_neighbours_are_compared():
    assert continuity(fit_of(keep=lambda window: window.begin != 5.0)).boundaries == 1


def test_windows_of_two_trials_do_not_join():
    fit = fit_of()
    windows = tuple(replace(window, trial=k) for k, window in enumerate(fit.windows))
    assert continuity(replace(fit, windows=windows)) is None


def test_a_single_window_has_nothing_to_join():
    assert continuity(fit_of(duration=np.inf)) is None


def test_a_value_that_no_window_shows_does_not_matter():
    fit = fit_of()
    model = fit.model.with_effect(ActiveEffect(EFFECTS["impulse.inner"], trial=1))
    with_it = refine(model, np.append(fit.values, [0.0, 1.0]), fit.windows)
    assert continuity(with_it).relative == pytest.approx(continuity(fit).relative, rel=0.01)


@pytest.mark.parametrize("key", ["encoder_offset.inner", "backlash.outer"])
def test_the_rods_are_compared_and_not_what_their_encoders_show(key):
    fit = fit_of()
    model = fit.model.with_effect(ActiveEffect(EFFECTS[key]))
    values = np.append(fit.values, 0.05)
    shown = [
        replace(w, theta=model.predict(values, w.start, w)[0] - r)
        for w, r in zip(fit.windows, fit.residuals, strict=True)
    ]
    found = continuity(refine(model, values, shown))
    assert found.relative == pytest.approx(continuity(fit).relative, rel=0.4)
    assert found.boundaries == 3
