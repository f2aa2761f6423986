import numpy as np
import pytest

from cdp_ident.model.parameters import GROUPS, NOMINAL, physical_coefficients
from cdp_ident.model.simulation import simulate
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.trial.balance import WINDOW, motion_on_grid, residual, torques, windows
from cdp_ident.trial.lumped import fit_lumped

TIME = np.arange(2400) * 0.005
COEFFICIENTS = physical_coefficients({**NOMINAL, "c1": 0.003, "c2": 0.001})
A23, A33, a1, c1, c2, m2_l2, g = COEFFICIENTS
EXPECTED = [A23, A33, c1, c2, a1 * g, m2_l2 * g]
START = np.array([2.0, 2.6, 0.0, 0.0])


def balance(theta, cart=None):
    return windows(motion_on_grid(TIME, theta, cart))


def fit(of):
    return fit_lumped(of, np.ones(len(of), dtype=bool))


def test_the_lumped_numbers_of_a_simulated_pendulum_are_recovered():
    assert [group.symbol for group in GROUPS][:3] == ["A23_over_A22", "A33_over_A22", "a1_over_A22"]
    of = balance(simulate(COEFFICIENTS, START, TIME)[:, :2])
    found = fit(of)
    assert np.allclose(found.values[:6], EXPECTED, rtol=2e-2, atol=5e-3)
    assert np.allclose(found.values[6:], 0, atol=0.05)
    assert found.unexplained < 0.002
    assert found.is_mechanism
    assert found.length_over_gravity == pytest.approx(NOMINAL["L"] / g, rel=0.01)
    assert np.abs(residual(of, found.values)).max() < 0.01 * EXPECTED[4]


def test_the_measured_motion_of_the_cart_is_part_of_the_balance():
    frequency, amplitude = 9.0, 0.03
    u = -amplitude * frequency**2 * np.sin(frequency * TimeGrid.over(TIME, 0.005).half_step_times())
    theta = simulate(COEFFICIENTS, START, TIME, u)[:, :2]
    with_cart, without = fit(balance(theta, amplitude * np.sin(frequency * TIME))), fit(balance(theta))
    assert 10 * with_cart.unexplained < 0.05 < without.unexplained
    assert with_cart.values[:6] == pytest.approx(EXPECTED, rel=0.05, abs=0.02)


def test_a_hand_in_a_third_of_the_windows_does_not_change_the_fit():
    theta = simulate(COEFFICIENTS, START, TIME)[:, :2]
    theta[:800] = theta[0] + 0.5 * np.sin(np.column_stack([3 * TIME[:800], 5 * TIME[:800]]))
    motion = motion_on_grid(TIME, theta, None)
    of = windows(motion)
    found = fit(of)
    assert np.allclose(found.values[:6], EXPECTED, rtol=2e-2, atol=1e-2)
    error = torques(of, found.values)
    begins, ends = motion.time[: len(error)], motion.time[WINDOW - 1 :]
    assert np.median(error[ends < 4.0]) > 20 * np.median(error[begins > 4.0])


def test_upside_down_angles_turn_gravity_round_and_nothing_else():
    theta = simulate(COEFFICIENTS, START, TIME)[:, :2]
    upright, hanging = (fit(balance(angles)) for angles in (theta, theta + np.pi))
    assert np.allclose(hanging.values[:6], upright.values[:6] * [1, 1, 1, 1, -1, -1], rtol=1e-6, atol=1e-9)
    assert not hanging.is_mechanism
    assert hanging.is_mechanism_upside_down


def test_zeros_that_are_off_are_found_with_their_size():
    theta = simulate(COEFFICIENTS, START, TIME)[:, :2]
    assert fit(balance(theta)).offsets.tolist() == [0, 0]
    assert fit(balance(theta - [0.03, -0.06])).offsets == pytest.approx([0.03, -0.06], abs=2e-3)


def test_noise_is_not_taken_for_something_unexplained():
    theta = simulate(COEFFICIENTS, START, TIME)[:, :2]
    noisy = theta + np.random.default_rng(1).normal(0, 5e-3, theta.shape)
    assert fit(balance(noisy)).unexplained < 0.01
