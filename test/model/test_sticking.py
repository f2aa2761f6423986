# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Joints with dry friction stop, stand still and break loose as in a simulation that locates every event."""

import math

import numpy as np
import pytest

from cdp_ident.model.motions import simulate
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid
from reference import torques
from reference.dry_friction import NO_FRICTION, DryFriction
from reference.mechanics import Rig
from reference.pendulum import TABLE_5
from reference.plant import Plant
from reference.sticking import motion, path
from scenarios.effects import acting
from scenarios.paper_rig import A22, COEFFICIENTS

TIMES = np.arange(2001) * 0.005
START = np.array([np.pi + 0.7, np.pi - 0.5, 0.0, 0.0])
"""A start from which the motion is regular: what is wrong by a little stays so."""
WIDE = np.array([2.2, 2.6, 0.0, 0.0])
MASS_BELOW = {"inner": TABLE_5["m1"] + TABLE_5["m0"] + TABLE_5["m2"], "outer": TABLE_5["m2"]}


def friction_of(joint, values):
    """Return effects of a joint with their values, and the reference's friction: nothing, Coulomb's or Stribeck's."""
    if not values:
        return [], NO_FRICTION
    if len(values) == 1:
        return [(f"coulomb_friction.{joint}", values)], DryFriction(torque=values[0] * A22)
    torque, extra, speed = values
    friction = DryFriction(torque=torque * A22, extra=extra * A22, speed=speed)
    return [(f"stribeck_friction.{joint}", values)], friction


def simulated(effects, start=START, times=TIMES, step=DEFAULT_STEP, u=None):
    return simulate(COEFFICIENTS, start, times, u, step, acting(*effects))


def both(inner, outer):
    (first, dry1), (second, dry2) = friction_of("inner", inner), friction_of("outer", outer)
    return [*first, *second], dry1, dry2


FRICTIONS = pytest.mark.parametrize(
    ("inner", "outer"),
    [
        ((0.03,), ()),
        ((), (0.03,)),
        ((0.3,), (0.1,)),
        ((), (1.0,)),
        ((3.0,), ()),
        ((3.0,), (1.0,)),
        ((8.0,), (4.0,)),
        ((20.0,), (0.1,)),
        ((20.0,), (20.0,)),
        ((0.2, 0.2, 0.4), ()),
        ((), (0.1, 0.3, 0.1)),
        ((0.2, 0.3, 0.1), (0.1, 0.1, 0.05)),
    ],
    ids=str,
)


@FRICTIONS
def test_dry_friction_is_the_reference_s_to_a_microradian_over_ten_seconds_of_regular_motion(inner, outer):
    effects, dry1, dry2 = both(inner, outer)
    expected = motion(TABLE_5, START, TIMES, dry1, dry2)
    assert np.abs(simulated(effects) - expected)[:, :2].max() < 1e-6


@FRICTIONS
def test_irregular_motion_is_the_reference_s_from_a_start_that_differs_by_less_than_a_tenth_of_a_microradian(
    inner, outer
):
    effects, dry1, dry2 = both(inner, outer)
    expected, near = (motion(TABLE_5, WIDE + by * np.eye(4)[0], TIMES, dry1, dry2) for by in (0.0, 1e-8))
    grows = np.abs(near - expected)[:, :2].max() / 1e-8
    assert np.abs(simulated(effects, WIDE) - expected)[:, :2].max() < 1e-7 * max(grows, 10.0)


@pytest.mark.parametrize("joint", ["inner", "outer"])
def test_friction_by_a_bearing_s_load_is_the_reference_s(joint):
    lever, mass = 2e-4, MASS_BELOW[joint]
    friction = DryFriction(lever=lever)
    dry = {"inner": NO_FRICTION, "outer": NO_FRICTION, joint: friction}
    with_load = motion(TABLE_5, START, TIMES, dry["inner"], dry["outer"])
    without = motion(TABLE_5, START, TIMES)
    found = simulated([(f"load_friction.{joint}", (lever, mass / A22))])
    # The load is taken from the motion without friction, which differs by as little as friction is against gravity.
    assert np.abs(found - with_load)[:, :2].max() < 0.01 * np.abs(without - with_load)[:, :2].max()


@pytest.mark.parametrize(("step", "limit"), [(0.02, 2e-6), (0.01, 1e-6), (DEFAULT_STEP, 1e-6), (0.001, 1e-8)])
def test_events_are_located_whatever_the_step(step, limit):
    effects, dry1, dry2 = both((3.0,), (1.0,))
    error = np.abs(simulated(effects, step=step) - motion(TABLE_5, START, TIMES, dry1, dry2))[:, :2].max()
    assert error < limit


def test_a_joint_that_sticks_stands_exactly_still():
    effects, dry1, dry2 = both((20.0,), (0.1,))
    expected = path(Plant(Rig(TABLE_5), dry1, dry2), START, TIMES)
    states = simulated(effects)
    (stuck,) = np.nonzero(expected.states[:, 2] == 0.0)
    assert len(stuck) > 500
    inside = stuck[np.isin(stuck - 1, stuck) & np.isin(stuck + 1, stuck)]
    assert np.all(states[inside, 2] == 0.0)
    held = states[inside[np.isin(inside - 1, inside)], 0]
    assert np.array_equal(np.unique(held), np.unique(states[inside, 0]))
    assert len(np.unique(states[inside, 0])) < 20


def test_both_rods_turn_as_one_while_the_outer_joint_sticks():
    effects, dry1, dry2 = both((), (20.0,))
    states = simulated(effects)
    expected = motion(TABLE_5, START, TIMES, dry1, dry2)
    together = np.flatnonzero(expected[:, 2] == expected[:, 3])
    together = together[np.isin(together - 1, together) & np.isin(together + 1, together)]
    assert len(together) > 500
    assert np.ptp(states[together, 2]) > 0.1
    assert np.array_equal(states[together, 2], states[together, 3])
    np.testing.assert_allclose(np.ptp((states[:, 1] - states[:, 0])[together[-500:]]), 0.0, atol=1e-12)


def test_once_both_joints_stick_nothing_moves_any_more():
    effects, dry1, dry2 = both((8.0,), (4.0,))
    at = path(Plant(Rig(TABLE_5), dry1, dry2), START, TIMES)
    assert at.event_modes[-1].tolist() == [0, 0]
    rest = simulated(effects)[at.event_times[-1] + DEFAULT_STEP < TIMES]
    assert len(rest) > 100
    assert np.all(rest == rest[0])
    assert np.all(rest[:, 2:] == 0.0)


@pytest.mark.parametrize(("share", "stays"), [(1.0001, True), (0.9999, False)])
def test_a_rod_that_is_let_go_within_its_static_friction_stays_and_else_breaks_loose(share, stays):
    angle = 0.1
    start = np.array([math.pi + angle, math.pi + angle, 0.0, 0.0])
    A23, _, a1, _, _, L, g = COEFFICIENTS
    needed = (a1 + A23 / L) * g * math.sin(angle)
    last = simulated(both((share * needed,), (100.0,))[0], start, TIMES[:20])[-1]
    assert np.array_equal(last, start) == stays
    assert last[0] <= start[0]
    # Stribeck's extra counts at rest, too.
    more = simulated(both((0.5 * needed, (share - 0.5) * needed, 0.1), (100.0,))[0], start, TIMES[:20])[-1]
    assert np.array_equal(more, start) == stays


def test_a_joint_holds_while_the_other_one_goes_though_it_would_not_hold_both():
    # Let go at rest, the inner joint could not hold both rods, but can hold its own.
    (A23, _, a1, _, _, L, g), friction = COEFFICIENTS, 20.0
    assert g * (a1 * math.sin(WIDE[0]) + A23 / L * math.sin(WIDE[1])) > friction
    effects, dry1, dry2 = both((friction,), (0.1,))
    states = simulated(effects, WIDE, TIMES[:20])
    assert np.all(states[:, 0] == WIDE[0])
    assert states[-1, 1] > WIDE[1]
    np.testing.assert_allclose(states, motion(TABLE_5, WIDE, TIMES[:20], dry1, dry2), rtol=0, atol=1e-7)


def test_a_cart_that_shakes_breaks_a_joint_loose():
    effects, _, _ = both((3.0,), (3.0,))
    hanging = np.array([math.pi, math.pi, 0.0, 0.0])
    shake = np.sin(5.0 * TimeGrid.over(TIMES[:400]).half_step_times())
    gently, hard = (simulated(effects, hanging, TIMES[:400], u=size * shake) for size in (0.1, 10.0))
    assert np.all(gently == hanging)
    assert np.ptp(hard[:, 0]) > 0.01


@pytest.mark.parametrize("joint", ["inner", "outer"])
@pytest.mark.parametrize("give", [5e-4, 1e-3, 0.01, 0.05])
@pytest.mark.parametrize("over", [0.1, 0.6])
def test_presliding_friction_is_the_reference_s(joint, give, over):
    times = TIMES[:300]
    found = simulated([(f"presliding_friction.{joint}", [over, give])], WIDE, times)
    given = torques.dahl(joint, over * A22, over * A22 / give)
    expected = motion(TABLE_5, WIDE, times, torques=[given])
    assert np.abs(found[:, :4] - simulated([], WIDE, times)).max() > 1e-2
    np.testing.assert_allclose(found[:, :2], expected[:, :2], rtol=0, atol=3e-7)
    assert np.all(np.abs(found[:, 4]) <= 1.0 + 1e-9)
