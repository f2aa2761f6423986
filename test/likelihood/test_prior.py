# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known of values beforehand scales with the rig and keeps curves smooth."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism
from cdp_ident.likelihood.prior import bending, known_before, known_of, typical
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.model.effects.effect import EffectParameter
from cdp_ident.model.parameters import CONSTANTS, time_unit

UNIT = time_unit(*(constant.nominal for constant in CONSTANTS))
"""Of the paper's rig [s]."""
DRY = next(effect for effect in CATALOGUE if effect.key == "coulomb_friction.outer")
OVER_ANGLE = next(curve for curve in CURVES if curve.curve.over == "angle" and not curve.dry)
OVER_SPEED = next(curve for curve in CURVES if curve.curve.over == "speed")


def parameter(unit, **more):
    return EffectParameter("p", unit, -1e9, 1e9, 0.02, **more)


@pytest.mark.parametrize(
    ("unit", "power"),
    [("N m", -2), ("N m/rad", -2), ("N m/rad^3", -2), ("N m s", -1), ("rad/s", -1), ("s", 1), ("rad", 0), ("", 0)],
)
def test_what_has_a_second_in_its_unit_scales_with_the_time_unit(unit, power):
    assert typical(parameter(unit), UNIT) == pytest.approx(0.02)
    assert typical(parameter(unit), 3.0 * UNIT) == pytest.approx(0.02 * 3.0**power)


def test_a_typical_value_stays_within_its_limits():
    assert typical(EffectParameter("p", "N m", 0.0, 0.05, 0.02), 0.1 * UNIT) == 0.05


@pytest.mark.parametrize(("shape", "times"), [(False, 100.0), (True, 2.0)])
def test_a_strength_is_around_zero_and_far_wider_than_a_shape_around_its_typical_value(shape, times):
    effect = replace(DRY, parameters=(parameter("N m", shape=shape),))
    precision, centre = known_of(ActiveEffect(effect), 2.0 * UNIT)
    assert precision[0, 0] ** -0.5 == pytest.approx(times * 0.02 / 4.0)
    assert centre[0] == pytest.approx(0.005 if shape else 0.0)


def test_a_width_of_its_own_takes_the_place_of_the_usual_one():
    precision, _ = known_of(ActiveEffect(replace(DRY, parameters=(parameter("N m", width=3.0),))), UNIT)
    assert precision[0, 0] == pytest.approx(3.0**-2)


def test_a_curve_over_angle_may_be_constant_or_turn_around_and_one_over_speed_may_be_a_line():
    over_angle, over_speed = bending(OVER_ANGLE.curve), bending(OVER_SPEED.curve)
    assert np.ones(len(over_angle)) @ over_angle @ np.ones(len(over_angle)) == pytest.approx(0.0)
    line = np.arange(len(over_speed), dtype=float)
    assert line @ over_speed @ line == pytest.approx(0.0)
    jump = np.arange(len(over_angle), dtype=float)  # from the end of a turn to its beginning
    assert jump @ over_angle @ jump > 1.0
    shifted = np.roll(np.roll(over_angle, 7, axis=0), 7, axis=1)
    np.testing.assert_array_equal(shifted, over_angle)


def test_a_curve_that_may_bend_more_is_less_smooth_and_as_large():
    rough, smooth = (known_of(ActiveEffect(OVER_ANGLE, bend=bend), UNIT)[0] for bend in (1.0, 0.01))
    ripple = (-1.0) ** np.arange(len(rough))
    assert ripple @ smooth @ ripple > 1e3 * (ripple @ rough @ ripple)
    flat = np.ones(len(rough))
    assert flat @ smooth @ flat == pytest.approx(flat @ rough @ flat)


def test_of_a_model_nothing_but_its_effects_and_weights_is_known_and_the_rows_say_so():
    model = MotionModel(Mechanism(0.4, 9.81, 0.4, 0.03)).with_effect(ActiveEffect(DRY))
    known = known_before(model)
    assert np.all(known.precision[:5] == 0.0)
    of_effect, _ = known_of(ActiveEffect(DRY), time_unit(0.4, 9.81))
    np.testing.assert_allclose(known.precision[5:, 5:], of_effect)
    assert known.logarithm == pytest.approx(-math.log(np.linalg.det(of_effect)))
    values, change = np.linspace(1.0, 2.0, len(known.centre)), np.linspace(-1.0, 1.0, len(known.centre))
    off = values + change - known.centre
    rows = known.rows(values)
    squares = np.sum((rows @ np.append(change, 1.0)) ** 2)
    assert squares == pytest.approx(off @ known.precision @ off)
