# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What encoders show of a motion: their errors, play, lateness and a rod that bends, as described independently."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.model.acting import NO_EFFECTS
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.motions import InitialValueProblem, motions, readings_of, simulate
from cdp_ident.model.time_grid import TimeGrid
from reference import encoders
from reference.dry_friction import DryFriction
from reference.encoders import Turned, joint_angles
from reference.mechanics import Rig
from reference.pendulum import TABLE_5, accelerations
from reference.plant import Path, Plant
from reference.sticking import path
from scenarios.effects import EFFECTS, acting
from scenarios.paper_rig import A22, COEFFICIENTS

V = TABLE_5
COMPLIANCE = 2e-3
"""Deflection of the inner rod's end over the force there [m/N]."""
SAG = COMPLIANCE * (V["m2"] + V["m0"]) * V["g"] / V["L"]
SWING = COMPLIANCE * V["m2"] * V["l2"] * V["g"] / V["L"] ** 2
START = np.array([np.pi + 1.3, np.pi - 1.9, 0.0, 0.0])
TIME = 0.05 + np.arange(200) / 100.0
PHASE = np.random.default_rng(0).uniform(-math.pi, math.pi)
"""Of an eccentric disc [rad]."""


def rods(times):
    """Return the motion of the paper's model (n, 4)."""
    return simulate(COEFFICIENTS, START, times, step=0.001)


def problem(effects, start=START, time=TIME, begin=0.0):
    """Return a motion with effects, given by key or as they are."""
    chosen = acting(*((effect, values) for effect, *values in effects), fitted=True)
    return InitialValueProblem(COEFFICIENTS, start, TimeGrid.over(time, 0.001), effects=chosen, begin=begin)


def shown(*effects, **given):
    return motions([problem(effects, **given)]).readings


def turning(time, states):
    """Return what turns the encoders in a motion (n, 4) of the paper's model."""
    moved = Path(time, states, np.array([accelerations(V, state, 0.0) for state in states]), np.zeros(len(time)))
    return Turned(V, moved, joint_angles(moved))


def in_joints(name, described, *values):
    return [(f"{name}.{joint}", values, described(joint, *values)) for joint in JOINTS]


def late(turned):
    """Return what an outer encoder shows that is read later than the inner one."""
    moved = rods(turned.path.times - DELAY)[:, :2] - turned.path.states[:, :2]
    return np.diff(moved, axis=1, prepend=moved[:, :1])


DELAY = 0.0123
DESCRIBED = [
    *in_joints("encoder_offset", encoders.offset, 0.02),
    *in_joints("encoder_scale", encoders.scale, 0.03),
    *in_joints("encoder_slip", encoders.slip, 0.1, 0.7),
    # The inner one's wave is over the angle from upright.
    *((f"encoder_eccentricity.{joint}", (side * 0.03 * np.cos(PHASE), side * 0.03 * np.sin(PHASE)),
       encoders.eccentricity(joint, 0.03, PHASE)) for joint, side in zip(JOINTS, (-1.0, 1.0), strict=True)),
    ("time_offset.outer", (DELAY,), late),
    ("rod_flex.inner", (SAG, SWING, 0.8), encoders.rod_flex(COMPLIANCE, 0.8)),
]  # fmt: skip


@pytest.mark.parametrize(("key", "values", "described"), DESCRIBED, ids=[key for key, *_ in DESCRIBED])
def test_an_encoder_shows_what_an_independent_description_says(key, values, described):
    plain = shown()
    expected = described(turning(TIME, rods(TIME)))
    assert np.abs(expected).max() > 1e-3
    assert np.abs(shown((key, *values)) - plain - expected).max() < 2e-6


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("delay", [0.0123, -0.0123], ids=["late", "early"])
@pytest.mark.parametrize("beside", [False, True], ids=["alone", "beside other effects"])
def test_either_encoder_may_be_late_or_early(joint, delay, beside):
    late = replace(EFFECTS["time_offset.outer"], joint=JOINTS[joint])
    others = [(f"{name}.{JOINTS[joint]}", 0.05) for name in ("encoder_scale", "backlash") if beside]
    others += [("rod_flex.inner", SAG, SWING, 0.5)] * beside
    found = motions([problem([(late, delay), *others])], derive=True)
    then, now = shown(*others, time=TIME - delay), shown(*others)
    then[:, 1 - joint] = now[:, 1 - joint]
    np.testing.assert_allclose(found.readings, then, rtol=0, atol=1e-9)
    sides = [shown((late, delay + step), *others) for step in (1e-6, -1e-6)]
    expected = (sides[0] - sides[1]) / 2e-6
    assert np.abs(found.by[..., found.ends.shape[1] + 7] - expected).max() < 1e-4 * np.abs(expected).max()


def test_an_encoder_with_play_whose_joint_rests_goes_on_to_show_what_it_showed():
    hanging = np.array([np.pi, np.pi, 0.0, 0.0, 0.3])
    assert shown(("backlash.inner", 0.1), start=hanging)[:, 0] == pytest.approx(np.pi - 0.015, abs=1e-12)


@pytest.mark.parametrize("joint", JOINTS)
def test_at_no_gap_the_derivative_by_it_is_against_the_motion(joint):
    given, column = problem([(f"backlash.{joint}", 0.0)]), JOINTS.index(joint)
    found, states = motions([given], derive=True), motions([given], shown=False).states
    np.testing.assert_allclose(found.readings, shown(), rtol=0, atol=1e-6)
    speed = states[:, 2] if joint == "inner" else states[:, 3] - states[:, 2]
    assert found.by[:, column, -1] == pytest.approx(-0.5 * np.sign(speed))
    assert not found.by[:, 1 - column, -1].any()


@given(st.lists(st.integers(1, 190), max_size=5), st.sampled_from(["backlash.outer", "presliding_friction.inner"]))
def test_a_motion_goes_on_from_where_a_piece_of_it_ended(cuts, key):
    effect = (key, *(p.typical for p in EFFECTS[key].parameters))
    bounds, time, start, pieces = [0, *sorted({5 * cut for cut in cuts})], 1e-3 * np.arange(1, 1001), START, []
    for first, last in zip(bounds, [*bounds[1:], 1000], strict=True):
        piece = problem([effect], start, time[: last - first])
        piece = replace(piece, grid=TimeGrid.over(time[: last - first], 0.001))
        found = motions([piece])
        pieces.append(found.readings)
        start = found.ends[0]
    np.testing.assert_allclose(np.concatenate(pieces), shown(effect, time=time), rtol=0, atol=1e-7)


@pytest.mark.parametrize("joint", JOINTS)
@given(
    st.lists(st.tuples(st.floats(0.1, 1.0), st.floats(1.0, 8.0)), min_size=1, max_size=3), st.floats(0.01, 0.3)
)  # fmt: skip
def test_an_encoder_with_play_follows_a_given_motion_as_described_independently(joint, waves, gap):
    time = 5e-4 * np.arange(4000)
    angle = sum(size * (1.0 - np.cos(rate * time)) for size, rate in waves)
    speed = sum(size * rate * np.sin(rate * time) for size, rate in waves)
    given, column = np.zeros((len(time), 7)), JOINTS.index(joint)
    given[:, column], given[:, 2 + column] = angle, speed
    found, exact = (
        readings_of(COEFFICIENTS, given, np.zeros((2, of.states - 4)), 5e-4, of)
        for of in (acting((f"backlash.{joint}", [gap])), NO_EFFECTS)
    )
    moved = Path(time, given[:, :4], given[:, :2], given[:, 0])
    expected = encoders.backlash(joint, 0.5 * gap)(Turned(V, moved, joint_angles(moved)))
    np.testing.assert_allclose(found - exact, expected, atol=1e-5)


@pytest.mark.parametrize("torque", [0.0, 0.5])
def test_a_rod_that_bends_does_so_as_described_independently_also_where_joints_stick(torque):
    time = np.arange(201) / 100.0
    plant = Plant(Rig(V), DryFriction(torque), DryFriction(0.2 * torque)) if torque else Plant(Rig(V))
    moved = path(plant, START, time)
    turned = Turned(V, moved, joint_angles(moved))
    expected = turned.joints + encoders.rod_flex(COMPLIANCE)(turned) + [np.pi, 0.0]
    sizes = zip(JOINTS, (torque / A22, 0.2 * torque / A22), strict=True)
    friction = [(f"coulomb_friction.{joint}", size) for joint, size in sizes if torque]
    found = shown(("rod_flex.inner", SAG, SWING, 0.5), *friction, time=time)
    assert np.abs(expected - turned.joints - [np.pi, 0.0]).max() > 2e-3
    assert np.abs(found - expected).max() < 1e-6
    if torque:
        assert np.any(np.diff(moved.states[:, 0]) == 0.0)


def bend(theta1, theta2=0.0, alpha1=0.0, cart=0.0):
    """Return by how much both encoders are off, given a rod that is bent by its own weight alone."""
    motion, flex = (
        np.array([[theta1, theta2, 0.0, 0.0, alpha1, 0.0, cart]]),
        acting(("rod_flex.inner", [1.0, 0.0, 0.5])),
    )
    return (readings_of(COEFFICIENTS, motion, np.zeros((2, 0)), 0.01, flex) - [theta1, theta2 - theta1])[0]


def test_a_rod_that_falls_freely_along_its_end_is_straight_and_a_cart_bends_it_as_gravity_would():
    assert bend(0.7, 0.2, V["g"] * np.sin(0.7) / V["L"]) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert bend(0.5 * np.pi) == pytest.approx([-1.0, -0.5])
    assert bend(0.0, cart=-V["g"]) == pytest.approx([-1.0, -0.5])


@pytest.mark.parametrize("delay", [1e3, -1e3, np.inf, np.nan])
def test_an_encoder_that_is_senselessly_late_shows_nothing(delay):
    assert not np.isfinite(shown(("time_offset.outer", delay))[:, 1]).any()
