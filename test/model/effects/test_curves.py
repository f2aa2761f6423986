"""Curves of any shape over a joint's angle or speed."""

import math

import numpy as np
import pytest

from cdp_ident.model.effects.catalogue import curve_law, kind_of
from cdp_ident.model.effects.curves import CURVES, basis

EACH = pytest.mark.parametrize("effect", CURVES, ids=lambda effect: effect.key)


def along(effect, at):
    """Return the law's torque (n,) and its slopes (n, 2 + count) at angles or speeds; the other of the two is 1."""
    count = effect.curve.count
    values = np.random.default_rng(1).normal(size=(1, count))
    torques, slopes = np.empty(len(at)), np.empty((len(at), 2 + count))
    for k, x in enumerate(at):
        scratch = np.full((2, 2 + count), np.nan)
        state = (x, 1.0) if effect.curve.over == "angle" else (1.0, x)
        torques[k] = curve_law(kind_of(effect), *state, values, 0, scratch)
        slopes[k] = scratch[0, : 2 + count]
    return values[0], torques, slopes


@EACH
def test_the_compiled_law_is_the_spline_of_its_basis(effect):
    at = np.random.default_rng(0).normal(scale=8.0, size=300)
    values, torques, slopes = along(effect, at)
    contributions = basis(effect.curve, at)
    np.testing.assert_allclose(torques, contributions @ values, atol=1e-12)
    np.testing.assert_allclose(slopes[:, 2:], contributions, atol=1e-12)


@EACH
def test_its_slope_is_that_of_differences(effect):
    at = np.random.default_rng(0).normal(scale=8.0, size=300)
    _, ahead, _ = along(effect, at + 1e-6)
    _, behind, _ = along(effect, at - 1e-6)
    _, _, slopes = along(effect, at)
    own, other = (0, 1) if effect.curve.over == "angle" else (1, 0)
    np.testing.assert_allclose(slopes[:, own], (ahead - behind) / 2e-6, atol=1e-6 * np.abs(slopes[:, own]).max())
    assert np.all(slopes[:, other] == 0.0)


@EACH
def test_equal_coefficients_are_an_even_torque(effect):
    at = np.linspace(-50.0, 50.0, 1001)
    np.testing.assert_allclose(basis(effect.curve, at).sum(axis=1), 1.0, rtol=1e-12)


@EACH
def test_four_coefficients_at_most_are_felt_anywhere(effect):
    contributions = basis(effect.curve, np.linspace(-50.0, 50.0, 1001))
    assert np.count_nonzero(contributions > 1e-15, axis=1).max() == 4


def test_over_the_angle_it_repeats_with_each_turn():
    curve = CURVES[0].curve
    at = np.linspace(-3.0, 3.0, 50)
    np.testing.assert_allclose(basis(curve, at + 4.0 * math.pi), basis(curve, at), atol=1e-12)


def test_speeds_beyond_all_that_occur_change_nothing_more():
    curve = next(effect.curve for effect in CURVES if effect.curve.over == "speed")
    np.testing.assert_array_equal(basis(curve, np.array([1e3])), basis(curve, np.array([1e6])))
