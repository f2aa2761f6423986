# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The motion that a script makes, and the drive of the cart: never more than its limits allow."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.rig.emulator.motion import Drive, DrivenCart, Hold, LetGo, Motion, MoveCart, Wait
from cdp_ident.rig.protocol import WATCHDOG_SECONDS

COEFFICIENTS = physical_coefficients(NOMINAL)
SCRIPT = (Wait(0.5), Hold(1.0, 2.0, 1.0), Wait(0.5), LetGo(), Wait(3.0))


def test_the_hand_leads_smoothly_holds_still_and_lets_go_into_the_models_own_motion():
    samples = Motion(COEFFICIENTS, SCRIPT, 0.005).advance(1000)
    angles = samples[:, 1:3]
    assert angles[:100] == pytest.approx(math.pi, abs=1e-12)
    assert np.abs(np.diff(angles[:400], n=2, axis=0)).max() < 0.005**2 * 5.8 * 2.2  # the path's largest acceleration
    assert angles[300:400] == pytest.approx(np.tile([1.0, 2.0], (100, 1)), abs=1e-12)
    free = simulate(
        COEFFICIENTS,
        np.array([1.0, 2.0, 0.0, 0.0]),
        np.linspace(0.005, 3.0, 600),
        step=0.005 / 3,
    )
    assert angles[400:] == pytest.approx(free[:, :2], abs=1e-9)
    assert np.all(samples[:, 0] == 0.0)


@pytest.mark.parametrize("pieces", [[1] * 900, [7, 300, 1, 592], [256, 256, 256, 132]])
def test_the_motion_is_the_same_however_it_is_asked_for(pieces):
    whole = Motion(COEFFICIENTS, SCRIPT, 0.005).advance(900)
    motion = Motion(COEFFICIENTS, SCRIPT, 0.005)
    assert np.concatenate([motion.advance(count) for count in pieces]) == pytest.approx(whole, abs=1e-7)


def test_a_moving_cart_shakes_the_pendulum_and_stops_where_it_was_told():
    motion = Motion(COEFFICIENTS, (MoveCart(0.2, 1.0), Wait(1.0)), 0.005)
    samples = motion.advance(400)
    assert samples[-1, 0] == pytest.approx(0.2, abs=1e-12)
    assert np.abs(np.diff(samples[:, 0], n=2)).max() < 0.005**2 * 5.8 * 0.2
    # While the cart speeds up towards +x, the rods stay behind: they lean towards -x, beyond pi.
    assert samples[40:60, 1].min() > math.pi
    assert not motion.finished


def test_a_swinging_pendulum_can_be_caught_without_a_jump_of_its_speed():
    samples = Motion(COEFFICIENTS, (Hold(1.0, 2.0, 1.0), LetGo(), Wait(0.4), Hold(1.0, 1.0, 0.5)), 0.005).advance(400)
    speed = np.diff(samples[:, 1:3], axis=0) / 0.005
    assert np.abs(np.diff(speed, axis=0)).max() < 1.5


def test_after_its_end_the_last_command_goes_on():
    motion = Motion(COEFFICIENTS, (Hold(1.0, 2.0, 1.0),), 0.005)
    samples = motion.advance(1000)
    assert motion.finished
    assert samples[-500:, 1:3] == pytest.approx(np.tile([1.0, 2.0], (500, 1)), abs=1e-12)


PERIOD = 0.005
TIMES = np.linspace(0.0, PERIOD, 11)
DRIVE = Drive(lag=0.01, acceleration=10.0, speed=1.5, rail=0.4)


def moved(commands, drive=DRIVE):
    """Return positions and accelerations over time, by a command, or none, a period."""
    cart = DrivenCart(drive)
    parts = []
    for command in commands:
        if command is not None:
            cart.command(command)
        position, acceleration = cart.advance(TIMES)
        parts.append(np.column_stack([position, acceleration])[:-1])
    positions, accelerations = np.concatenate(parts).T
    return positions, accelerations


@given(
    commands=st.lists(st.none() | st.floats(-1e6, 1e6), min_size=1, max_size=300),
    times=st.integers(1, 30),
    lag=st.sampled_from([1e-4, 0.01, 0.3]),
)
def test_no_command_drives_it_past_a_limit(commands, times, lag):
    positions, accelerations = moved(list(np.repeat(np.array(commands), times))[:2000], Drive(lag, 10.0, 1.5, 0.4))
    assert np.abs(positions).max() <= 0.4 + 1e-9
    assert np.abs(np.diff(positions)).max() <= 1.5 * TIMES[1] + 1e-9
    assert np.abs(accelerations).max() <= 10.0 + 1e-6


def test_it_follows_commands_within_its_limits_with_its_lag():
    positions, accelerations = moved([2.0] * 40)
    time = np.arange(len(positions)) * TIMES[1]
    np.testing.assert_allclose(accelerations, 2.0 * -np.expm1(-time / DRIVE.lag), atol=1e-9)
    expected = time**2 - 2.0 * DRIVE.lag * (time - DRIVE.lag * -np.expm1(-time / DRIVE.lag))
    np.testing.assert_allclose(positions, expected, atol=1e-12)


def test_its_position_is_the_integral_of_its_acceleration_whatever_is_asked_for():
    positions, accelerations = moved([30.0] * 20 + [-4.0] * 50 + [None] * 60 + [7.0] * 100)
    curvature = np.diff(positions, 2) / TIMES[1] ** 2
    np.testing.assert_allclose(curvature, accelerations[1:-1], atol=0.6)
    assert np.median(np.abs(curvature - accelerations[1:-1])) < 1e-3


def commanded(acceleration):
    """Return a cart that has obeyed for a quarter of a second."""
    cart = DrivenCart(DRIVE)
    for _ in range(50):
        cart.command(acceleration)
        cart.advance(TIMES)
    return cart


def brakes_to_rest(cart):
    """Let half a second go by; return whether it has braked as hard as it can, and rests."""
    obeyed = cart.obeys
    positions, accelerations = zip(*(cart.advance(TIMES) for _ in range(100)), strict=True)
    hardest, last = np.min(accelerations), np.abs(accelerations[-1]).max()
    return not obeyed and hardest == pytest.approx(-10.0, rel=0.01) and last < 1e-6 and np.ptp(positions[-1]) < 1e-9


def test_it_brakes_to_rest_when_commands_stop_and_not_before():
    silent = round(WATCHDOG_SECONDS / PERIOD)
    cart = commanded(5.0)
    for _ in range(silent - 1):
        assert cart.obeys
        _, acceleration = cart.advance(TIMES)
    assert acceleration[-1] == pytest.approx(5.0, rel=0.01)
    cart.advance(TIMES)
    assert brakes_to_rest(cart)


def test_it_brakes_to_rest_when_the_device_was_reset():
    cart = commanded(5.0)
    cart.forget_command()
    assert brakes_to_rest(cart)


def test_it_stops_at_the_rail_s_end_and_comes_back():
    positions, _ = moved([3.0] * 400 + [-3.0] * 100)
    there = positions[: 400 * 10]
    assert there[-1] == pytest.approx(0.4, abs=1e-3)
    assert positions[-1] < 0.3
    assert math.isclose(positions.max(), there.max())
