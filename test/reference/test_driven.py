# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A driven cart is gravity in another direction; the equations of motion with u, from the Lagrangian, say the same."""

import numpy as np
import pytest
import sympy

from reference.driven import DrivenRods
from reference.mechanics import Cart, Rig
from reference.pendulum import TABLE_5, TIME, cart_acceleration, motion
from reference.plant import Plant

START = np.array([2.0, 1.5, 0.0, 0.0])
CART = sympy.Rational(1, 20) * sympy.sin(6 * TIME)
SPACING = 1e-3


def driven(plant):
    rods = DrivenRods(plant, START)
    middles = SPACING * (np.arange(1000) + 0.5)
    for pushes in np.split(cart_acceleration(CART, middles), 200):
        rods.advance(pushes, SPACING)
    return rods


@pytest.mark.parametrize("cart", [None, Cart(1.0, 1e9, 1e4)], ids=["held fast", "hardly gives way"])
def test_it_moves_as_the_equations_of_motion_say(cart):
    rods = driven(Plant(Rig(TABLE_5, cart=cart)))
    expected = motion(TABLE_5, START, np.array([0.0, 1.0]), CART)[-1]
    np.testing.assert_allclose(rods.now.states[0], expected, atol=1e-5)
    assert rods.now.times[0] == pytest.approx(1.0)
