# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Curves of any shape over a joint's angle or speed."""

import math

import numpy as np
import pytest

from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.curves import CURVES, basis
from cdp_ident.model.motions import accelerations_at
from cdp_ident.model.parameters import NOMINAL, physical_coefficients

EACH = pytest.mark.parametrize("effect", CURVES, ids=lambda effect: effect.key)
COEFFICIENTS = physical_coefficients(NOMINAL)


@EACH
def test_the_compiled_law_is_the_spline_of_its_basis(effect):
    at = np.random.default_rng(0).normal(scale=8.0, size=300)
    values = np.random.default_rng(1).uniform(0.0, 1.0, effect.curve.count)
    angle, speed = (at, np.ones(300)) if effect.curve.over == "angle" else (np.ones(300), at)
    inner, zero = effect.joint == "inner", np.zeros(300)
    states = np.stack([angle + math.pi, zero, speed, zero] if inner else [zero, angle, zero, speed], axis=1)
    acting = ActingEffects.of([(effect, values)], 0.4)
    added = accelerations_at(COEFFICIENTS, states, zero, acting) - accelerations_at(COEFFICIENTS, states, zero)
    coupling = COEFFICIENTS[0] * np.cos(states[:, 0] - states[:, 1])
    torques = added[:, 0] + coupling * added[:, 1], coupling * added[:, 0] + COEFFICIENTS[1] * added[:, 1]
    expected = (-1.0 if effect.dry else 1.0) * basis(effect.curve, at) @ values
    np.testing.assert_allclose(torques, [expected, zero] if inner else [-expected, expected], atol=1e-10)


@EACH
def test_equal_coefficients_are_an_even_torque_and_four_at_most_are_felt_anywhere(effect):
    contributions = basis(effect.curve, np.linspace(-50.0, 50.0, 1001))
    np.testing.assert_allclose(contributions.sum(axis=1), 1.0, rtol=1e-12)
    assert np.count_nonzero(contributions > 1e-15, axis=1).max() == 4


@EACH
def test_over_the_angle_it_repeats_with_each_turn_and_speeds_beyond_all_that_occur_change_nothing_more(effect):
    if effect.curve.over == "angle":
        at = np.linspace(-3.0, 3.0, 50)
        np.testing.assert_allclose(basis(effect.curve, at + 4.0 * math.pi), basis(effect.curve, at), atol=1e-12)
    else:
        np.testing.assert_array_equal(*(basis(effect.curve, np.array([at])) for at in (1e3, 1e6)))
