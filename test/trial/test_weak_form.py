# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
import sympy

from cdp_ident.trial.scales import PER_UNIT, Scales
from cdp_ident.trial.weak_form import WINDOW, Motion, integrated, over_windows, window_weights
from reference import own_units, pendulum
from reference.own_units import Rig
from reference.pendulum import TABLE_5, cart_position

START = np.array([2.0, 2.6, 0.0, 0.0])
SPACING = 0.05
TIME = np.arange(500) * SPACING
RIG = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01, dry1=0.02, dry2=0.03, coupling=0.05)
"""In units of its own, in which L and g are one: G1 is a1, and G2 is A23."""
OF_RIG = {
    "A22": 1.0, "A23": 0.5, "A33": 0.4, "c1": 0.02, "c2": 0.01, "G1": 1.4, "G2": 0.5, "k1": 0.02, "k2": 0.03, "D": 0.05,
}  # fmt: skip


@pytest.fixture(scope="module")
def states():
    return own_units.motion(RIG, START, TIME)


def motion_of(states, cart=None, spacing=SPACING):
    """A motion of states (n, 4) [rad, rad/s] on a grid of a spacing [s], with the cart's speed [m/s]."""
    none = np.zeros(len(states))
    scales, cart = Scales(PER_UNIT * spacing), none if cart is None else cart
    return Motion(spacing * np.arange(len(states)), states[:, :2], states[:, 2:], none, cart, scales, np.zeros(2), 0.0)


def speeds_of_joints(states):
    return np.column_stack([states[:, 2], states[:, 3] - states[:, 2]])


def left(motion, gravity, numbers):
    """What is left in each window of both rods' balance (windows, 2) with all numbers, and (n, windows, 2) by each."""
    parts = integrated(motion, gravity, list(numbers), 3)[0] * list(numbers.values())
    return parts.sum(axis=-1), np.moveaxis(parts, -1, 0)


def test_the_balance_holds_along_a_motion_of_a_rig_and_with_no_term_left_out(states):
    motion = motion_of(states)
    rest, parts = left(motion, 1.0, OF_RIG)
    moves = np.all(integrated(motion, 1.0, (), 3)[1] < 1e-3, axis=1)
    assert np.count_nonzero(moves) > 10
    assert np.abs(rest[moves]).max() < 1e-3
    for part in parts:
        assert np.abs(rest - part)[moves].max() > 10 * np.abs(rest[moves]).max()


def test_a_moving_cart_is_part_of_the_balance():
    m1, m2, m0, l1, l2, J1, J2, c1, c2, L, g = TABLE_5.values()
    A22 = m1 * l1**2 + J1 + (m2 + m0) * L**2
    cart = 0.03 * sympy.sin(9 * pendulum.TIME)
    time = np.arange(400) * 0.01
    states = pendulum.motion(TABLE_5, START, time, cart, lambda _, state: (0.0, 0.0), 1e-8)
    numbers = {
        "A22": A22, "A23": m2 * l2 * L, "A33": m2 * l2**2 + J2, "G1": (m1 * l1 + (m2 + m0) * L) * g, "G2": m2 * l2 * g,
        "c1": c1, "c2": c2,
    }  # fmt: skip
    numbers = {name: value / A22 for name, value in numbers.items()}
    moved = motion_of(states, cart_position(sympy.diff(cart, pendulum.TIME), time), spacing=0.01)
    assert np.abs(left(moved, g, numbers)[0]).max() < 3e-3
    assert np.abs(left(motion_of(states, spacing=0.01), g, numbers)[0]).max() > 1.0


@pytest.mark.parametrize(
    ("of", "by", "error"),
    [("A23", [1.0, 0.0], "E12"), ("A23", [0.0, -1.0], "E12"), ("G1", [1.0, 0.0], "E1"), ("G2", [0.0, 1.0], "E2")],
)
def test_an_error_of_a_zero_is_what_a_small_turn_of_it_changes(states, of, by, error):
    motion = motion_of(states)

    def column(name, turn):
        return integrated(replace(motion, angles=motion.angles + turn * np.array(by)), 1.0, [name], 3)[0]

    difference = (column(of, 1e-5) - column(of, -1e-5)) / 2e-5
    assert np.abs(difference).max() > 0.1
    assert column(error, 0.0) == pytest.approx(difference, abs=1e-8)


def test_a_derivative_is_integrated_by_parts():
    value, slope = window_weights(SPACING, half=50)
    by_parts = over_windows(np.sin(TIME), slope)
    assert by_parts == pytest.approx(over_windows(np.cos(TIME), value), abs=1e-5)
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
