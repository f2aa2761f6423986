import numpy as np
import pytest
import sympy

from cdp_ident.trial.weak_form import COLUMNS, Kinematics, Windows, integrated
from reference import own_units, pendulum
from reference.own_units import Rig
from reference.pendulum import TABLE_5, cart_position

START = np.array([2.0, 2.6, 0.0, 0.0])
SPACING = 0.01
TIME = np.arange(2000) * SPACING
WINDOWS = Windows.of(50, SPACING, 5)
RIG = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01, dry1=0.02, dry2=0.03, coupling=0.05)
"""In units of its own, in which L and g are one: G1 is a1, and G2 is A23."""
OF_RIG = {
    "A22": 1.0, "A23": 0.5, "A33": 0.4, "c1": 0.02, "c2": 0.01, "G1": 1.4, "G2": 0.5, "k1": 0.02, "k2": 0.03, "D": 0.05,
}  # fmt: skip


@pytest.fixture(scope="module")
def states():
    return own_units.motion(RIG, START, TIME)


@pytest.fixture(scope="module")
def kinematics(states):
    return Kinematics(SPACING, states[:, :2], states[:, 2:], np.zeros(len(TIME)))


def speeds_of_joints(states):
    return np.column_stack([states[:, 2], states[:, 3] - states[:, 2]])


def left(k, windows, directions, gravity, numbers):
    """What is left in each window of both rods' balance (windows, 2) with all numbers, and (n, windows, 2) by each."""
    parts = integrated(k, windows, directions, gravity, list(numbers)) * list(numbers.values())
    return parts.sum(axis=-1), np.moveaxis(parts, -1, 0)


def test_the_balance_holds_along_a_motion_of_a_rig_and_with_no_term_left_out(states, kinematics):
    speeds = speeds_of_joints(states)
    slips = [WINDOWS.within(np.abs(speeds[:, joint]) > 1e-9) for joint in range(2)]
    moves = slips[0] & slips[1]
    assert np.mean(moves) > 0.3
    rest, parts = left(kinematics, WINDOWS, np.sign(speeds), 1.0, OF_RIG)
    assert np.abs(rest[moves]).max() < 1e-3
    for part in parts:
        assert np.abs(rest - part)[moves].max() > 10 * np.abs(rest[moves]).max()


def test_a_moving_cart_and_springs_across_the_joints_are_part_of_the_balance():
    m1, m2, m0, l1, l2, J1, J2, c1, c2, L, g = TABLE_5.values()
    A22 = m1 * l1**2 + J1 + (m2 + m0) * L**2
    springs = {"s1": 0.4, "t1": 0.3, "s2": 0.2, "t2": -0.1}
    cart = 0.03 * sympy.sin(9 * pendulum.TIME)

    def torque(_, state):
        inner = springs["t1"] - springs["s1"] * (state[0] - np.pi)
        outer = springs["t2"] - springs["s2"] * (state[1] - state[0])
        return A22 * (inner - outer), A22 * outer

    time = np.arange(400) * SPACING
    states = pendulum.motion(TABLE_5, START, time, cart, torque, 1e-8)
    k = Kinematics(SPACING, states[:, :2], states[:, 2:], cart_position(sympy.diff(cart, pendulum.TIME), time))
    numbers = {
        "A22": A22, "A23": m2 * l2 * L, "A33": m2 * l2**2 + J2, "G1": (m1 * l1 + (m2 + m0) * L) * g, "G2": m2 * l2 * g,
        "c1": c1, "c2": c2,
    }  # fmt: skip
    numbers = {name: value / A22 for name, value in numbers.items()} | springs
    directions = np.zeros((len(time), 2))
    rest, parts = left(k, Windows.of(12, SPACING, 3), directions, g, numbers)
    assert np.abs(rest).max() < 3e-3
    assert all(np.abs(part).max() > 0.05 for part in parts[-4:])
    at_rest = Kinematics(SPACING, k.theta, k.rates, np.zeros(len(time)))
    assert np.abs(left(at_rest, Windows.of(12, SPACING, 3), directions, g, numbers)[0]).max() > 1.0


@pytest.mark.parametrize(
    ("of", "by", "error"),
    [("A23", [1.0, 0.0], "E12"), ("A23", [0.0, -1.0], "E12"), ("G1", [1.0, 0.0], "E1"), ("G2", [0.0, 1.0], "E2")],
)
def test_an_error_of_a_zero_is_what_a_small_turn_of_it_changes(kinematics, of, by, error):
    def column(name, turn):
        turned = Kinematics(SPACING, kinematics.theta + turn * np.array(by), kinematics.rates, kinematics.cart)
        return integrated(turned, WINDOWS, np.zeros_like(turned.theta), 1.0, [name])

    difference = (column(of, 1e-5) - column(of, -1e-5)) / 2e-5
    assert np.abs(difference).max() > 0.1
    assert column(error, 0.0) == pytest.approx(difference, abs=1e-8)


def test_a_derivative_is_integrated_by_parts():
    windows = Windows.of(50, SPACING)
    assert windows.slopes_of(np.sin(TIME)) == pytest.approx(windows.values_of(np.cos(TIME)), abs=1e-5)
    assert windows.values_of(np.ones(200)) == pytest.approx(1.0)


@pytest.mark.parametrize("stride", [1, 3, 4, 100])
@pytest.mark.parametrize("points", [0, 24, 25, 26, 97, 100])
def test_windows_lie_a_stride_apart_as_long_as_they_fit(points, stride):
    windows = Windows.of(12, SPACING, stride)
    series = np.random.default_rng(0).normal(size=(2, points))
    firsts = range(0, points - 24, stride)
    directly = [series[:, first : first + 25] @ windows.value for first in firsts]
    assert windows.count(points) == len(firsts)
    assert windows.values_of(series) == pytest.approx(np.array(directly).reshape(len(firsts), 2).T)
    if points >= 25:
        flags = np.random.default_rng(1).random(points) > 0.02
        assert windows.within(flags).tolist() == [bool(flags[first : first + 25].all()) for first in firsts]


def test_what_is_measured_several_times_is_integrated_each_time(kinematics):
    rng = np.random.default_rng(0)
    theta, rates = (of + rng.normal(scale=1e-3, size=(3, *of.shape)) for of in (kinematics.theta, kinematics.rates))
    cart = rng.normal(size=(3, len(TIME)))
    together = Kinematics(SPACING, theta, rates, cart)
    widths = [0.1, 0.2]
    found = integrated(together, WINDOWS, together.directions(widths), 9.81, COLUMNS)
    for index in range(3):
        one = Kinematics(SPACING, theta[index], rates[index], cart[index])
        alone = integrated(one, WINDOWS, one.directions(widths), 9.81, COLUMNS)
        assert found[index] == pytest.approx(alone, abs=1e-12)


def test_the_direction_of_slip_is_the_mean_sign_of_a_speed_of_known_noise(kinematics):
    widths = np.array([0.1, 0.4])
    noise = np.random.default_rng(0).normal(size=(4000, 1, 2)) * widths
    some = Kinematics(SPACING, kinematics.theta[::40], kinematics.rates[::40], kinematics.cart[::40])
    expected = np.mean(np.sign(some.joint_speeds + noise), axis=0)
    assert some.directions(widths) == pytest.approx(expected, abs=0.06)


def test_the_direction_of_slip_is_sure_where_a_joint_is_fast_and_nowhere_else(states, kinematics):
    speeds = speeds_of_joints(states)
    directions = kinematics.directions([0.02, 0.02])
    fast = np.abs(speeds) > 0.1
    assert directions[fast] == pytest.approx(np.sign(speeds[fast]), abs=1e-5)
    assert np.abs(directions[np.abs(speeds) < 1e-9]).max() < 1e-6
    assert np.array_equal(kinematics.directions([0.0, 0.0])[fast], np.sign(speeds[fast]))


def test_angles_of_joints_are_none_where_the_rods_hang():
    hanging = Kinematics(SPACING, np.full((3, 2), np.pi), np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 2.0]]), np.zeros(3))
    assert hanging.joint_angles == pytest.approx(np.zeros((3, 2)))
    assert hanging.joint_speeds.tolist() == [[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]]
