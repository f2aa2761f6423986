"""A rod that bends: what its encoders show, as described independently, and its derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.windows import Window
from cdp_ident.model.effects.bending import ROD_FLEX, Load, bends, bent
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.model.time_grid import TimeGrid
from reference import encoders
from reference.dry_friction import DryFriction
from reference.encoders import Turned, joint_angles, theta_of
from reference.mechanics import Rig
from reference.pendulum import TABLE_5
from reference.plant import Plant
from reference.sticking import path

V = TABLE_5
COMPLIANCE = 2e-3
"""Deflection of the rod's end over the force there [m/N]."""
SAG = COMPLIANCE * (V["m2"] + V["m0"]) * V["g"] / V["L"]
SWING = COMPLIANCE * V["m2"] * V["l2"] * V["g"] / V["L"] ** 2
START = np.array([np.pi + 1.3, np.pi - 1.9, 0.0, 0.0])
TIME = np.arange(201) / 100.0
EFFECTS = {effect.key: effect for effect in CATALOGUE}


def model_with(*strengths, friction=()):
    """Return the model of a rod that bends by `sag` and `swing`, beside dry friction, and its values."""
    mechanism = Mechanism.of(Prior({"L": V["L"], "g": V["g"]}))
    model, values = MotionModel(mechanism), [*groups_of([V[s] for s in SYMBOLS], V["L"])]
    for joint, torque in friction:
        model = model.with_effect(ActiveEffect(EFFECTS[f"coulomb_friction.{joint}"]))
        values.append(torque / A22)
    return model.with_effect(ActiveEffect(ROD_FLEX)), np.array([*values, *strengths])


A22 = V["m1"] * V["l1"] ** 2 + V["J1"] + (V["m2"] + V["m0"]) * V["L"] ** 2


def window_of(time, u=None):
    grid = TimeGrid.over(time)
    push = np.zeros(2 * grid.steps + 1) if u is None else u(grid.half_step_times())
    return Window(0, 0, 0.0, time, np.empty((0, 2)), grid, push, START)


@pytest.mark.parametrize("torque", [0.0, 0.5])
def test_encoders_show_what_an_independent_description_says_also_where_joints_stick(torque):
    plant = Plant(Rig(V), DryFriction(torque), DryFriction(0.2 * torque)) if torque else Plant(Rig(V))
    moved = path(plant, START, TIME)
    turned = Turned(V, moved, joint_angles(moved))
    described = theta_of(turned.joints + encoders.rod_flex(COMPLIANCE)(turned))
    friction = [("inner", torque), ("outer", 0.2 * torque)] if torque else []
    model, values = model_with(SAG, SWING, friction=friction)
    shown, _ = model.predict(values, START, window_of(TIME), "none")
    assert np.abs(described - theta_of(turned.joints)).max() > 2e-3
    assert np.abs(shown - described).max() < 1e-6
    if torque:
        assert np.any(np.diff(moved.states[:, 0]) == 0.0)


def test_without_a_bend_encoders_show_the_rods_and_the_derivatives_by_the_strengths_are_what_these_would_add():
    model, values = model_with(0.0, 0.0)
    angles, by_all = model.predict(values, START, window_of(TIME))
    plain, _ = replace(model, effects=()).predict(values[:-2], START, window_of(TIME))
    assert np.array_equal(angles, plain)
    both, _ = model.predict(np.array([*values[:-2], SAG, SWING]), START, window_of(TIME), "none")
    assert plain + by_all[..., -2:] @ [SAG, SWING] == pytest.approx(both, abs=1e-12)


def test_derivatives_over_a_moving_cart_and_beside_a_late_encoder_are_those_of_differences():
    model, values = model_with(SAG, SWING)
    model = model.with_effect(ActiveEffect(EFFECTS["time_offset.outer"]))
    values = np.array([*values, 0.004])
    window = window_of(TIME, lambda time: 3.0 * np.sin(4.0 * time))
    _, found = model.predict(values, START, window)
    point = np.concatenate([START, values])
    for direction, unit in enumerate(1e-6 * np.eye(len(point))):
        sides = [model.predict((point + step)[4:], (point + step)[:4], window)[0] for step in (unit, -unit)]
        expected = (sides[0] - sides[1]) / 2e-6
        assert np.abs(found[..., direction] - expected).max() <= 1e-4 * np.abs(expected).max() + 1e-9


def test_a_rod_that_falls_freely_along_its_end_is_straight():
    states = np.array([[0.7, 0.2, 0.0, 0.0]])
    falling, along = V["g"] * np.sin(0.7) / V["L"], np.zeros(1)
    assert bends(states, np.array([[falling, 0.0]]), along, V["L"], V["g"]) == pytest.approx(np.zeros((1, 2)))


def test_a_cart_that_is_pushed_bends_the_rod_as_gravity_along_it_would():
    level, upright = np.array([[0.5 * np.pi, 0.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.0, 0.0]])
    held, still = np.zeros((1, 2)), np.zeros(1)
    by_weight = bends(level, held, still, V["L"], V["g"])
    by_push = bends(upright, held, still - V["g"], V["L"], V["g"])
    assert by_push == pytest.approx(by_weight)
    assert by_weight == pytest.approx(np.array([[-1.0, 0.0]]))


def test_a_motion_that_ends_in_no_numbers_ends_so_in_what_is_shown():
    states = np.array([[0.1, 0.2, 0.0, 0.0], [np.nan] * 4])
    load = Load(V["L"], V["g"], lambda states, delay: (np.zeros((2, 2)), np.zeros(2)))
    shown, _ = bent(lambda delay: (states, np.empty((2, 2, 0))), load, [SAG, SWING], 0)(0.0)
    assert np.isfinite(shown[0]).all()
    assert np.isnan(shown[1]).all()
