"""What is read from a fitted model about one of its effects."""

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.tracing.evidence import Attempt

BY_KEY = {effect.key: effect for effect in CATALOGUE}
GROUPS = np.array([0.08, 0.06, 2.6, 0.07, 0.01])


def attempt(key: str, values: list[float]) -> Attempt:
    model = MotionModel(Mechanism(0.4, 9.81, 0.4, 0.05), effects=(ActiveEffect(BY_KEY[key], trial=0),))
    fit = Fit(model, np.concatenate([GROUPS, values]), (), (), (), (), 1, 1, True)
    return Attempt(fit, fit, folds=())


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
    assert Attempt(fit, fit, folds=()).place_of("coulomb_friction.outer") == 1
