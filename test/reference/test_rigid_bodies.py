# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rigid-body engine that knows nothing of our equations moves the same plants the same way."""

import numpy as np
import pytest

from reference import rigid_bodies, sticking, torques
from reference.dry_friction import DryFriction
from reference.mechanics import Cart, Rig
from reference.pendulum import TABLE_2, TABLE_5
from reference.plant import Plant

TIMES = np.arange(801) / 200.0
START = (3.9, 4.4, 0.0, 0.0)
LIGHT, HEAVY = Cart(0.3, 2e4, 20.0), Cart(5.0, 500.0, 5.0)
SPRINGS = (torques.spring("inner", 0.05, -0.2), torques.spring("outer", 0.02, 0.3))


@pytest.mark.parametrize("cart", [None, LIGHT, HEAVY])
@pytest.mark.parametrize("values", [TABLE_2, TABLE_5])
def test_smooth_motion_agrees(values, cart):
    plant = Plant(Rig(values, rotor=1e-3, tilt=0.05, cart=cart), torques=SPRINGS)
    one, other = (engine.path(plant, START, TIMES) for engine in (rigid_bodies, sticking))
    assert np.abs(one.states[:, :2] - other.states[:, :2]).max() < 1e-7
    assert np.abs(one.cart - other.cart).max() < 1e-7


@pytest.mark.parametrize(
    ("inner", "outer", "cart", "springs"),
    [
        *((*sizes, None, ()) for sizes in [(0.02, 0), (0, 0.002), (0.2, 0), (0, 0.05), (0.03, 0.01), (0.2, 0.05)]),
        (0.05, 0.01, HEAVY, SPRINGS),
    ],
)
def test_dry_friction_agrees_within_the_engine_s_own_steps_on_a_compliant_base_too(inner, outer, cart, springs):
    plant = Plant(Rig(TABLE_5, cart=cart), DryFriction(inner), DryFriction(outer), springs)
    one, other = (engine.path(plant, START, TIMES) for engine in (rigid_bodies, sticking))
    assert np.abs(one.states[:, :2] - other.states[:, :2]).max() < 5e-5


def test_what_is_stuck_hardly_creeps():
    plant = Plant(Rig(TABLE_5), DryFriction(0.2), DryFriction(0.05))
    found = sticking.path(plant, START, TIMES)
    resting = found.event_times[-1] + 0.1 < TIMES
    assert found.event_modes[-1].tolist() == [0, 0]
    states = rigid_bodies.path(plant, START, TIMES).states[resting]
    assert np.abs(states[:, 2:]).max() < 2e-6
    assert np.ptp(states[:, :2], axis=0).max() < 2e-6


@pytest.mark.parametrize(
    "plant",
    [
        Plant(Rig(TABLE_5), DryFriction(0.1, extra=0.1)),
        Plant(Rig(TABLE_5), outer=DryFriction(lever=0.01)),
        Plant(Rig(TABLE_5), torques=(torques.magnet("inner", 0.01, 0.0, 0.1),)),
        Plant(Rig(TABLE_5), torques=(SPRINGS[0], SPRINGS[0])),
    ],
)
def test_what_the_engine_has_no_element_for_is_refused(plant):
    with pytest.raises(ValueError, match="no element"):
        rigid_bodies.path(plant, START, TIMES)
