# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The motion that a script makes."""

import math

import numpy as np
import pytest

from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.rig.emulator.motion import Motion
from cdp_ident.rig.emulator.script import Hold, LetGo, MoveCart, Wait

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
