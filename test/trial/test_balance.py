# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
import sympy

from cdp_ident.trial.balance import (
    COLUMNS,
    WINDOW,
    Motion,
    motion_on_grid,
    over_windows,
    residual,
    torques,
    window_weights,
    windows,
)
from cdp_ident.trial.lumped import fit_lumped
from cdp_ident.trial.scales import PER_UNIT, Scales
from reference import own_units, pendulum
from reference.own_units import Rig
from reference.pendulum import TABLE_2

START = np.array([2.0, 2.6, 0.0, 0.0])
SPACING = 0.05
GRID = np.arange(500) * SPACING
RIG = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01, dry1=0.02, dry2=0.03, coupling=0.05)
"""In units of its own, in which L and g are one: G1 is a1, and G2 is A23."""
OF_RIG = {
    "A22": 1.0, "A23": 0.5, "A33": 0.4, "c1": 0.02, "c2": 0.01, "G1": 1.4, "G2": 0.5, "k1": 0.02, "k2": 0.03, "D": 0.05,
}  # fmt: skip


@pytest.fixture(scope="module")
def states():
    return own_units.motion(RIG, START, GRID)


def motion_of(states):
    """A motion of states (n, 4) [rad, rad/s] on the grid."""
    none = np.zeros(len(states))
    scales, whole = Scales(PER_UNIT * SPACING), np.zeros(len(GRID), dtype=bool)
    return Motion(GRID, states[:, :2], states[:, 2:], none, none, scales, np.zeros(2), 0.0, whole)


def speeds_of_joints(states):
    return np.column_stack([states[:, 2], states[:, 3] - states[:, 2]])


def test_the_balance_holds_along_a_motion_of_a_rig_and_with_no_term_left_out(states):
    of = windows(motion_of(states), 1.0, 3)
    parts = of.terms[..., [COLUMNS.index(name) for name in OF_RIG]] * list(OF_RIG.values())
    moves = np.all(of.slack < 1e-3, axis=1)
    assert np.count_nonzero(moves) > 10
    rest = parts[moves].sum(axis=-1)
    assert np.abs(rest).max() < 1e-3
    for part in np.moveaxis(parts[moves], -1, 0):
        assert np.abs(rest - part).max() > 10 * np.abs(rest).max()


@pytest.mark.parametrize(
    ("of", "by", "error"),
    [("A23", [1.0, 0.0], "E12"), ("A23", [0.0, -1.0], "E12"), ("G1", [1.0, 0.0], "E1"), ("G2", [0.0, 1.0], "E2")],
)
def test_an_error_of_a_zero_is_what_a_small_turn_of_it_changes(states, of, by, error):
    motion = motion_of(states)

    def column(name, turn):
        turned = replace(motion, angles=motion.angles + turn * np.array(by))
        return windows(turned, 1.0, 3).terms[..., COLUMNS.index(name)]

    difference = (column(of, 1e-5) - column(of, -1e-5)) / 2e-5
    assert np.abs(difference).max() > 0.1
    assert column(error, 0.0) == pytest.approx(difference, abs=1e-8)


def test_samples_a_nanosecond_apart_ask_for_no_more_memory_than_others(states):
    angles, time = np.repeat(states[:, :2], 2, axis=0), np.repeat(GRID, 2)
    time[1::2] += 1e-9
    twice = motion_on_grid(time, angles, None, Scales(PER_UNIT * SPACING))
    assert np.isfinite(twice.gain)
    np.testing.assert_allclose(twice.angles[10:-10], states[10:-10, :2], atol=1e-2)


@pytest.mark.parametrize("kept", [1.0, 0.75, 0.64])
def test_noise_of_an_acceleration_is_that_of_the_samples_as_they_are_spaced(kept):
    generator = np.random.default_rng(1)
    time = np.arange(4000) / 60.0
    time = time[generator.random(4000) < kept]
    noise = motion_on_grid(time, generator.normal(size=(len(time), 2)), None, Scales(0.26))
    _, slope = window_weights(noise.scales.spacing)
    of_whole = [over_windows(rate, slope)[noise.is_whole] for rate in noise.rates.T]
    assert noise.gain == pytest.approx(np.median(np.square(of_whole)) / 0.455, rel=0.35)


def test_a_derivative_is_integrated_by_parts():
    value, slope = window_weights(SPACING, half=50)
    by_parts = over_windows(np.sin(GRID), slope)
    assert by_parts == pytest.approx(over_windows(np.cos(GRID), value), abs=1e-5)
    assert over_windows(np.ones(200), value) == pytest.approx(1.0)


@pytest.mark.parametrize("stride", [1, 3, 100])
@pytest.mark.parametrize("points", [0, WINDOW - 1, WINDOW, 97])
def test_windows_lie_a_stride_apart_as_long_as_they_fit(points, stride):
    value, _ = window_weights(SPACING)
    series = np.random.default_rng(0).normal(size=points)
    directly = [series[first : first + WINDOW] @ value for first in range(0, points - WINDOW + 1, stride)]
    assert over_windows(series, value, stride) == pytest.approx(np.array(directly))


def test_the_direction_of_slip_is_the_mean_sign_of_a_speed_of_known_noise(states):
    speeds, motion = speeds_of_joints(states), motion_of(states)
    noise = np.random.default_rng(0).normal(scale=motion.scales.slow, size=(4000, 1, 2))
    assert motion.directions[::10] == pytest.approx(np.mean(np.sign(speeds[::10] + noise), axis=0), abs=0.06)
    sure, stands = np.abs(speeds) > 5.0 * motion.scales.slow, np.abs(speeds) < 1e-9
    assert motion.directions[sure] == pytest.approx(np.sign(speeds[sure]), abs=1e-5)
    assert np.abs(motion.directions[stands]).max() < 1e-6


TIME = np.arange(2400) * 0.005
BRISK = {**TABLE_2, "c1": 0.003, "c2": 0.001}


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


def test_the_lumped_numbers_of_a_simulated_pendulum_are_recovered(swing):
    of = balance(swing)
    found = fit_lumped(of)
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
    with_cart = fit_lumped(windows(motion_on_grid(time, theta, pendulum.cart_position(cart, time))))
    without = fit_lumped(windows(motion_on_grid(time, theta, None)))
    assert 10 * with_cart.unexplained < 0.05 < without.unexplained
    assert with_cart.values[:6] == pytest.approx(EXPECTED, rel=0.05, abs=0.02)


def test_a_hand_in_a_third_of_the_windows_does_not_change_the_fit(swing):
    theta = swing.copy()
    theta[:800] = theta[0] + 0.5 * np.sin(np.column_stack([3 * TIME[:800], 5 * TIME[:800]]))
    motion = motion_on_grid(TIME, theta, None)
    of = windows(motion)
    found = fit_lumped(of)
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
    upright, hanging = fit_lumped(balance(swing)), fit_lumped(balance(swing + np.pi * np.array(half_turns)))
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
