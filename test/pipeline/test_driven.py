# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motion that is driven by known torques or by a measured cart: right values, A22 from torques, and the right name."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.identifiability import identifiability
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.weights import Weight
from cdp_ident.pipeline.identify import identify, identify_and_trace
from scenarios.driven import FRICTION, NOISE, TIMES, driven_by_cart, driven_by_motors
from scenarios.paper_rig import A22, GROUPS

LAG = 0.003


@pytest.fixture(scope="module")
def by_motors():
    trials = [driven_by_motors(seed, LAG) for seed in (1, 3)]
    return identify_and_trace(trials[:1], trials[1:], IdentifyOptions())


@pytest.fixture(scope="module")
def by_cart():
    options = IdentifyOptions(named_effects_only=True)  # quicker; beside motors, curves are looked for, too
    *trials, held_out = (driven_by_cart(seed, TIMES[:1000]) for seed in (1, 2, 3))
    return identify_and_trace(trials, [held_out], options)


def deviations(traced):
    """Return by how many of their standard deviations the base parameters and the friction are off."""
    fit, std = traced.completed.fit, np.sqrt(np.diag(traced.covariance))
    true = [*GROUPS, FRICTION / A22]
    places = [*range(len(GROUPS)), fit.model.names.index("quadratic_friction.outer.coefficient")]
    return (fit.values[places] - true) / std[places]


@pytest.mark.parametrize("driver", ["by_motors", "by_cart"])
def test_base_parameters_are_right_and_what_the_model_lacks_has_its_name(driver, request):
    _, traced = request.getfixturevalue(driver)
    assert [found.active.effect.key for found in traced.effects] == ["quadratic_friction.outer"]
    assert np.max(np.abs(deviations(traced))) < 4.0
    assert traced.errors["effects"].holdout.rmse < 1.5 * NOISE
    assert traced.errors["refined"].holdout.rmse > 5.0 * NOISE


def test_torques_in_newton_metres_show_the_inertia_as_well_as_they_are_known(by_motors):
    _, traced = by_motors
    inertia = traced.completed.inertia
    assert inertia.shown
    assert inertia.value == pytest.approx(A22, rel=2e-3)
    assert inertia.relative_std == pytest.approx(0.05, rel=0.1)
    (friction,) = traced.effects[0].parameters
    assert friction.value == pytest.approx(FRICTION, rel=0.02)
    assert friction.std == pytest.approx(0.05 * FRICTION, rel=0.2)


def test_a_motor_s_lag_is_found_and_said(by_motors):
    _, traced = by_motors
    fit = traced.completed.fit
    imbalance, *lags = fit.values[fit.model.places_of_motors]
    assert lags == pytest.approx([LAG, LAG], abs=3e-4)
    assert imbalance == pytest.approx(0.0, abs=5e-3)
    shown = identifiability(traced.completed)
    words = "; ".join(shown.words)
    assert "determined by the motors' torques, known to 5 %" in words
    assert "act 3 ms (inner joint) and 3 ms (outer joint) after their record" in words


def test_motors_and_weights_are_not_fitted_together():
    plain = driven_by_motors(1)
    weighted = replace(plain, weights=(Weight("outer", 0.05, 0.3),))
    with pytest.raises(IdentificationError, match="leave one kind out"):
        identify([plain, weighted], [], IdentifyOptions())
