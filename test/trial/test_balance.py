# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
import sympy

from cdp_ident.trial.balance import motion_on_grid, residual, torques, windows
from cdp_ident.trial.lumped import fit_lumped
from cdp_ident.trial.weak_form import WINDOW
from reference import own_units, pendulum
from reference.own_units import Rig
from reference.pendulum import TABLE_2

TIME = np.arange(2400) * 0.005
BRISK = {**TABLE_2, "c1": 0.003, "c2": 0.001}
START = np.array([2.0, 2.6, 0.0, 0.0])


def lumped_numbers(m1, m2, m0, l1, l2, J1, J2, c1, c2, L, g):
    A22 = m1 * l1**2 + J1 + (m2 + m0) * L**2
    return np.array([m2 * L * l2, m2 * l2**2 + J2, c1, c2, (m1 * l1 + (m2 + m0) * L) * g, m2 * l2 * g]) / A22


EXPECTED = lumped_numbers(**BRISK)


@pytest.fixture(scope="module")
def swing():
    theta = pendulum.motion(BRISK, START, TIME, tolerance=1e-9)[:, :2]
    theta.setflags(write=False)
    return theta


def balance(theta, cart=None):
    return windows(motion_on_grid(TIME, theta, cart))


def fit(of):
    return fit_lumped(of)


def test_the_lumped_numbers_of_a_simulated_pendulum_are_recovered(swing):
    of = balance(swing)
    found = fit(of)
    assert np.allclose(found.values[:6], EXPECTED, rtol=2e-2, atol=5e-3)
    assert np.allclose(found.values[6:], 0, atol=0.05)
    assert found.unexplained < 0.002
    assert found.is_mechanism
    assert found.length_over_gravity[0] == pytest.approx(0.4 / 9.81, rel=0.01)
    assert np.abs(residual(of, found.values)).max() < 0.01 * EXPECTED[4]


def test_the_measured_motion_of_the_cart_is_part_of_the_balance():
    time = TIME[:1600]
    cart = 0.03 * sympy.sin(9 * pendulum.TIME)
    theta = pendulum.motion(BRISK, START, time, cart, tolerance=1e-8)[:, :2]
    with_cart = fit(windows(motion_on_grid(time, theta, pendulum.cart_position(cart, time))))
    without = fit(windows(motion_on_grid(time, theta, None)))
    assert 10 * with_cart.unexplained < 0.05 < without.unexplained
    assert with_cart.values[:6] == pytest.approx(EXPECTED, rel=0.05, abs=0.02)


def test_a_hand_in_a_third_of_the_windows_does_not_change_the_fit(swing):
    theta = swing.copy()
    theta[:800] = theta[0] + 0.5 * np.sin(np.column_stack([3 * TIME[:800], 5 * TIME[:800]]))
    motion = motion_on_grid(TIME, theta, None)
    of = windows(motion)
    found = fit(of)
    assert np.allclose(found.values[:6], EXPECTED, rtol=2e-2, atol=1e-2)
    error = torques(of, found.values)
    begins, ends = motion.time[: len(error)], motion.time[WINDOW - 1 :]
    assert np.median(error[ends < 4.0]) > 20 * np.median(error[begins > 4.0])


@pytest.mark.parametrize(
    ("half_turns", "turned", "signs"),
    [
        ([1, 1], "both", [1, 1, 1, 1, -1, -1]),
        ([1, 0], "inner", [-1, 1, 1, 1, -1, 1]),
        ([0, 1], "outer", [-1, 1, 1, 1, 1, -1]),
    ],
)
def test_upside_down_angles_turn_gravity_round_and_nothing_else(swing, half_turns, turned, signs):
    upright, hanging = fit(balance(swing)), fit(balance(swing + np.pi * np.array(half_turns)))
    assert np.allclose(hanging.values[:6], upright.values[:6] * signs, rtol=1e-6, atol=1e-9)
    assert upright.is_mechanism
    assert not hanging.is_mechanism
    assert (upright.turned, hanging.turned) == ("", turned)


def test_where_a_joint_sticks_its_friction_has_any_direction_and_elsewhere_its_own():
    sticking = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01, dry1=0.02, dry2=0.2)
    time = np.arange(1600) * 0.025
    states = own_units.motion(sticking, START, time)
    theta = states[:, :2] + np.random.default_rng(1).normal(scale=1e-3, size=(len(time), 2))
    motion = motion_on_grid(time, theta, None)
    slack = windows(motion).slack
    speeds = np.column_stack([states[:, 2], states[:, 3] - states[:, 2]])
    stands = np.zeros((len(slack), 2), dtype=bool)
    runs = np.zeros((len(slack), 2), dtype=bool)
    for window, (first, last) in enumerate(zip(motion.time, motion.time[WINDOW - 1 :], strict=False)):
        inside = np.abs(speeds[(time >= first) & (time <= last)])
        stands[window], runs[window] = inside.max(axis=0) < 1e-9, inside.min(axis=0) > 0.1
    assert np.count_nonzero(runs[:, 0]) > 100
    assert np.count_nonzero(stands[:, 1]) > 100
    assert np.all(slack[runs] < 0.02)
    assert np.all(slack[stands] > 0.5)
