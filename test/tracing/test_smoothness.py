"""Curves are as smooth as the data say."""

import numpy as np
import pytest

from cdp_ident.model.effects.curves import CURVES, basis
from cdp_ident.tracing.smoothness import smooth_curve

CURVE = CURVES[0].curve
NOISE = 0.1


def measured(torque, noise=NOISE, seed=0):
    """Return the normal equations of samples of a torque over an angle, and the true torque at each."""
    rng = np.random.default_rng(seed)
    at = rng.uniform(-2.0, 2.0, 2000)
    columns, true = basis(CURVE, at), torque(at)
    return columns, columns.T @ columns, columns.T @ (true + rng.normal(scale=noise, size=len(at))), true


def magnet(at):
    return -at / 0.1 * np.exp(0.5 - 0.5 * (at / 0.1) ** 2)


@pytest.mark.parametrize("torque", [magnet, np.sin, lambda at: np.exp(-(at**2))], ids=["magnet", "sine", "bell"])
def test_a_smooth_curve_is_nearer_to_the_truth_than_one_left_to_itself(torque):
    columns, matrix, right, true = measured(torque)
    free = columns @ np.linalg.lstsq(matrix, right, rcond=1e-10)[0]
    smooth = columns @ smooth_curve(CURVE, matrix, right, NOISE**2).coefficients
    error, error_of_free = (np.sqrt(np.mean((found - true) ** 2)) for found in (smooth, free))
    assert error < 0.8 * error_of_free
    assert error < 0.25 * NOISE


def test_what_is_large_at_one_place_is_nothing_elsewhere():
    _, matrix, right, _ = measured(magnet)
    found = smooth_curve(CURVE, matrix, right, NOISE**2)
    away = basis(CURVE, np.linspace(1.0, 1.9, 50)) @ found.coefficients
    assert np.sqrt(np.mean(away**2)) < 0.1 * NOISE
    assert found.freedom < 0.3 * CURVE.count


def test_noise_alone_gains_next_to_nothing():
    _, matrix, right, _ = measured(np.zeros_like)
    found = smooth_curve(CURVE, matrix, right, NOISE**2)
    assert found.freedom < 5.0
    assert found.gain < 20.0 * NOISE**2


def test_where_nothing_was_measured_the_curve_is_no_larger_than_elsewhere():
    _, matrix, right, _ = measured(magnet)
    unseen = basis(CURVE, np.linspace(2.2, 4.0, 20)) @ smooth_curve(CURVE, matrix, right, NOISE**2).coefficients
    assert np.abs(unseen).max() < 0.2
