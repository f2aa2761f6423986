"""What is read from a fitted model about one of its effects."""

import numpy as np
import pytest

from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import Fit, refine, refine_from_afar
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing.evidence import Attempt, change
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5
from reference.truths import truth
from scenarios.twin import standard_twin

BY_KEY = {effect.key: effect for effect in CATALOGUE}
GROUPS = np.array([0.08, 0.06, 2.6, 0.07, 0.01])


def attempt(key: str, values: list[float]) -> Attempt:
    model = MotionModel(Mechanism(0.4, 9.81, 0.4, 0.05), effects=(ActiveEffect(BY_KEY[key], trial=0),))
    fit = Fit(model, np.concatenate([GROUPS, values]), (), (), (), (), 1, 1, True)
    return Attempt(fit, (), fit)


@pytest.mark.parametrize(
    ("key", "index", "which", "at_limit"),
    [
        ("encoder_offset.inner", 0, "lower", True),
        ("encoder_offset.inner", 0, "upper", True),
        ("load_friction.outer", 1, "lower", True),
        ("load_friction.outer", 1, "upper", True),
        ("coulomb_friction.inner", 0, "lower", False),  # no strength
        ("coulomb_friction.inner", 0, "upper", True),
    ],
)
def test_a_limit_is_run_into_but_no_strength_is_none(key, index, which, at_limit):
    values = [parameter.typical for parameter in BY_KEY[key].parameters]
    assert not attempt(key, values).at_limit(0)
    values[index] = getattr(BY_KEY[key].parameters[index], which)
    assert attempt(key, values).at_limit(0) == at_limit


def test_a_small_value_of_a_wide_range_is_not_at_its_limit():
    lever, mass = BY_KEY["load_friction.outer"].parameters
    assert not attempt("load_friction.outer", [lever.typical, 1.1 * mass.lower]).at_limit(0)


def test_an_instant_without_a_latest_one_is_at_no_limit():
    assert not attempt("impulse.inner", [0.1, 1e6]).at_limit(0)


def test_an_effect_is_found_by_its_key():
    model = MotionModel(Mechanism(0.4, 9.81, 0.4, 0.05))
    for key in ("air_drag.inner", "coulomb_friction.outer"):
        model = model.with_effect(ActiveEffect(BY_KEY[key]))
    fit = Fit(model, np.concatenate([GROUPS, [0.1, 0.1]]), (), (), (), (), 1, 1, True)
    assert Attempt(fit, (), fit).place_of("coulomb_friction.outer") == 1


def test_initial_states_that_an_effect_brings_explain_noise_alone_by_chance_alone():
    windows = cut_into_windows([standard_twin(np.random.default_rng(3))], 0.5)
    folds = tuple(tuple(range(len(windows))[k::4]) for k in range(4))
    model = MotionModel(Mechanism.of(Prior()))
    plain = attempt_of(refine(model, groups_of([TABLE_5[s] for s in SYMBOLS], TABLE_5["L"]), windows), folds)
    base = ActiveEffect(BY_KEY["pivot_compliance.base.oscillating"])
    values = np.concatenate([plain.fit.values, [1e-6, 10.0, 0.05]])
    oscillating = attempt_of(refine(model.with_effect(base), values, windows), folds)
    fall = (plain.validation.squared_error - oscillating.validation.squared_error) / oscillating.fit.variance
    gained = change(plain, oscillating)
    assert fall > len(windows)
    assert abs(gained.validation) < 0.5 * fall
    assert gained.validation == pytest.approx(-change(oscillating, plain).validation)
    assert gained.bic > 0.0


def test_friction_that_grows_with_the_load_is_as_strong_as_what_it_gains_though_lever_and_mass_make_up_for_each_other():
    made = truth("load_friction.inner", 95001, "equations")
    nominal = Prior(nominal=made.setting.nominal)
    trials = [Trial(measured.name, measured.time, measured.theta) for measured in made.trials[:2]]
    windows = cut_into_windows(trials, 1.9)
    model = MotionModel(Mechanism.of(nominal))
    plain = refine_from_afar(model, groups_of(nominal.centre, nominal.length), windows)
    friction = ActiveEffect(BY_KEY["load_friction.inner"])
    fit = refine(model.with_effect(friction), np.concatenate([plain.values, [7e-5, 10.0]]), plain.windows)
    before, found = Attempt(plain, ()), Attempt(fit, ())  # nothing is predicted
    lever = found.model.places(0).start
    with_any_mass = fit.values[lever] / np.sqrt(covariance(fit, remembered=False)[lever, lever])
    gained = change(before, found).fit
    assert with_any_mass < 0.5 * np.sqrt(gained)
    assert found.strength(0) == pytest.approx(np.sqrt(gained), rel=0.3)
