"""What the score test says of effects that a fitted model lacks."""

import math

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing.candidates import ScoreTest, addable
from cdp_ident.trial.trial import Trial
from reference.mechanics import Cart, Rig
from reference.pendulum import TABLE_5
from reference.plant import Plant
from reference.sticking import path
from scenarios.twin import as_measured

VALUES = [TABLE_5[symbol] for symbol in SYMBOLS]
RODS = TABLE_5["m1"] + TABLE_5["m2"] + TABLE_5["m0"]
TIMES = np.arange(1000) * 0.005
START = np.array([np.pi + 0.7, np.pi - 0.5, 0.0, 0.0])


@pytest.mark.parametrize(("mass", "frequency"), [(20.0, 10.0), (30.0, 5.0)])
def test_a_heavy_cart_on_a_soft_stand_is_seen_by_what_a_little_of_it_would_change(mass, frequency):
    cart = Cart(mass - RODS, mass * frequency**2, 2.0 * 0.1 * mass * frequency)
    motion = path(Plant(Rig(TABLE_5, cart=cart)), START, TIMES)
    theta = as_measured(motion.states[:, :2], np.random.default_rng(0), noise=3e-4)
    model = MotionModel(Mechanism.of(Prior()))
    plain = refine(model, groups_of(VALUES, TABLE_5["L"]), cut_into_windows([Trial("swing", TIMES, theta)], 1.25))
    first = ScoreTest(plain, addable(model)).ranked()[0]
    assert first.active.effect.key == "pivot_compliance.base.oscillating"
    compliance, found, _ = first.values
    assert compliance > 0.0
    assert abs(math.log2(found / frequency)) < 0.6


def test_a_joint_may_have_several_harmonics_but_of_other_effects_one_form() -> None:
    present = ("cogging_torque.outer.5 per turn", "air_drag.outer.rotation", "coulomb_friction.inner")
    model = MotionModel(Mechanism.of(Prior()))
    every = {active.effect.key for active in addable(model)}
    for effect in CATALOGUE:
        model = model.with_effect(ActiveEffect(effect)) if effect.key in present else model
    assert every - {active.effect.key for active in addable(model)} == {*present, "air_drag.outer.strips"}
