# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A law that acts at one place is fitted to a curve over the angle, from anywhere."""

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.curves import basis
from cdp_ident.tracing.shaped_like import _most_like, _torque, shaped_like_the_last
from scenarios.swings import UNIT, known, with_effect

VALUES = {"magnet": [2.0, 0.33, 0.1, 0.3], "end_stop": [15.0, -0.68, 0.1]}


@pytest.mark.parametrize(("name", "joint"), [("magnet", "outer"), ("end_stop", "inner"), ("end_stop", "outer")])
def test_it_is_found_at_its_place(name, joint):
    effect, curve = known(f"{name}.{joint}"), known(f"unknown_torque.{joint}.over_angle").curve
    angles = np.arange(curve.count) * (2.0 * np.pi / curve.count)
    torque = _torque(effect, np.array(VALUES[name]), (angles + np.pi) % (2.0 * np.pi) - np.pi)
    coefficients = np.linalg.solve(basis(curve, angles), torque)
    found = _most_like(effect, curve, coefficients, np.eye(curve.count), UNIT)
    # How much energy a stop takes does not show at rest.
    shown = [parameter.name != "loss" for parameter in ActiveEffect(effect).fitted]
    assert found[shown] == pytest.approx(np.array(VALUES[name])[shown], rel=1e-3)


def test_of_a_model_whose_last_effect_is_no_such_curve_there_is_none(clean):
    assert not list(shaped_like_the_last(with_effect(clean, "joint_spring.outer", 0.1, 0.0)))
    of_speed = with_effect(clean, "unknown_torque.outer.over_speed", *np.zeros(32))
    assert not list(shaped_like_the_last(of_speed))
