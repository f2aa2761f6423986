import numpy as np
import pytest

from cdp_ident.model.parameters import GROUPS, NOMINAL, physical_coefficients
from cdp_ident.model.simulation import simulate
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.trial.balance import WINDOW, fit_lumped, motion_on_grid, residual, windows

TIME = np.arange(2400) * 0.005
COEFFICIENTS = physical_coefficients({**NOMINAL, "c1": 0.003, "c2": 0.001})
A23, A33, a1, c1, c2, m2_l2, g = COEFFICIENTS
EXPECTED = [A23, A33, c1, c2, a1 * g, m2_l2 * g]
START = np.array([2.0, 2.6, 0.0, 0.0])


def balance(theta, cart=None):
    return windows(motion_on_grid(TIME, theta, cart))


def test_the_lumped_numbers_of_a_simulated_pendulum_are_recovered():
    assert [group.symbol for group in GROUPS][:3] == ["A23_over_A22", "A33_over_A22", "a1_over_A22"]
    coefficients, target = balance(simulate(COEFFICIENTS, START, TIME)[:, :2])
    fit = fit_lumped(coefficients, target, np.ones(len(target), dtype=bool))
    assert np.allclose(fit.values, EXPECTED, rtol=2e-2, atol=5e-3)
    assert fit.unexplained < 0.002
    assert fit.is_mechanism
    assert np.abs(residual(coefficients, target, fit.values)).max() < 0.01 * EXPECTED[4]


def test_the_measured_motion_of_the_cart_is_part_of_the_balance():
    frequency, amplitude = 9.0, 0.03
    u = -amplitude * frequency**2 * np.sin(frequency * TimeGrid.over(TIME, 0.005).half_step_times())
    theta = simulate(COEFFICIENTS, START, TIME, u)[:, :2]
    coefficients, target = balance(theta, amplitude * np.sin(frequency * TIME))
    everywhere = np.ones(len(target), dtype=bool)
    with_cart = fit_lumped(coefficients, target, everywhere)
    without = fit_lumped(*balance(theta), everywhere)
    assert 10 * with_cart.unexplained < 0.05 < without.unexplained
    assert with_cart.values == pytest.approx(EXPECTED, rel=0.05, abs=0.02)


def test_a_hand_in_a_third_of_the_windows_does_not_change_the_fit():
    theta = simulate(COEFFICIENTS, START, TIME)[:, :2]
    theta[:800] = theta[0] + 0.5 * np.sin(np.column_stack([3 * TIME[:800], 5 * TIME[:800]]))
    coefficients, target = balance(theta)
    fit = fit_lumped(coefficients, target, np.ones(len(target), dtype=bool))
    assert np.allclose(fit.values, EXPECTED, rtol=2e-2, atol=1e-2)
    error = np.abs(residual(coefficients, target, fit.values)).max(axis=1)
    hand = slice(0, 400 - WINDOW)
    free = slice(400 + WINDOW, None)
    assert np.median(error[hand]) > 20 * np.median(error[free])


def test_upside_down_angles_turn_gravity_round_and_nothing_else():
    theta = simulate(COEFFICIENTS, START, TIME)[:, :2]
    everywhere = np.ones(len(balance(theta)[1]), dtype=bool)
    upright, hanging = (fit_lumped(*balance(angles), everywhere) for angles in (theta, theta + np.pi))
    assert np.allclose(hanging.values, upright.values * [1, 1, 1, 1, -1, -1], rtol=1e-6, atol=1e-9)
    assert not hanging.is_mechanism
