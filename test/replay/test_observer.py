# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Velocities by the fitted model, beside those of the reference's motion."""

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.motions import simulate
from cdp_ident.replay.observer import Observer
from cdp_ident.replay.scene import MotionStream
from reference.pendulum import TABLE_5, TIME, cart_position, motion

PERIOD = 0.005
COUNTS = np.array([1e-5, math.tau / 8000, math.tau / 8000])
DRY = 0.0018
"""Of the outer joint [N m]; a sixth of it is hidden from the model."""
MODEL = fitted_model(TABLE_5 | {"effects.coulomb_friction.outer.torque": 0.0015}, "test")
PAPER = fitted_model(TABLE_5, "test")
OFF = fitted_model({s: v * (1.0 if s in "Lg" else 0.7 if "1" in s else 1.3) for s, v in TABLE_5.items()}, "test")
"""Nominal values, as are known before anything is identified."""
CART = 0.06 * sympy.sin(2.3 * TIME) + 0.03 * sympy.sin(5.1 * TIME) + 0.004 * sympy.sin(25.0 * TIME)
HANGING, SWING = (math.pi, math.pi, 0.0, 0.0), (1.5, 1.2, 0.0, 0.0)
MOTIONS = {"hanging": (HANGING, 0.0 * TIME), "swing": (SWING, 0.0 * TIME), "driven": (HANGING, CART)}


def friction(_time, state):
    torque = -DRY * math.tanh((state[3] - state[2]) / 0.01)
    return -torque, torque


def joints(cart, rods):
    return np.column_stack([cart, rods[:, 0], rods[:, 1] - rods[:, 0]])


def moved(kind, seconds=6.0):
    """Return times [s], counted positions and true velocities (n, 3) of cart, inner and outer joint."""
    (start, cart), times = MOTIONS[kind], np.arange(0.0, seconds, PERIOD)
    states = motion(TABLE_5, start, times, cart, friction, tolerance=1e-9)
    positions = joints(cart_position(cart, times), states[:, :2])
    # Between two counts, as joints at rest may be.
    positions += COUNTS * (0.5 + 1e-3 * np.random.default_rng(0).normal(size=positions.shape))
    velocities = joints(cart_position(sympy.diff(cart, TIME), times), states[:, 2:])
    return times, COUNTS * np.round(positions / COUNTS), velocities


def followed(observer, times, positions):
    """Return the velocities (n - 3, 3): there are none of the first three samples."""
    found = [observer.update(round(t * 1e9), at) for t, at in zip(times.tolist(), positions.tolist(), strict=True)]
    assert found[:3] == 3 * [()]
    return np.array(found[3:])


@pytest.mark.parametrize("kind", MOTIONS)
def test_velocities_are_better_than_a_parabola_s_and_do_not_lag(kind):
    times, positions, true = moved(kind)
    slope = np.linalg.pinv(np.vander(PERIOD * np.arange(-6, 1), 3))[1]
    parabola = np.apply_along_axis(np.convolve, 0, positions, slope[::-1], "valid")
    found = {"parabola": parabola} | {
        name: followed(Observer(model), times, positions) for name, model in (("fitted", MODEL), ("nominal", OFF))
    }
    errors = {name: (of[-1100:] - true[-1100:])[:, 1:] for name, of in found.items()}
    rms = {name: np.sqrt(np.mean(error**2, axis=0)) for name, error in errors.items()}
    assert np.all(rms["fitted"] < 0.45 * rms["parabola"])
    assert np.all(rms["nominal"] < 1.7 * rms["parabola"])
    assert np.std(found["fitted"][-1100:, 0] - true[-1100:, 0]) < 2e-3
    if kind != "hanging":
        accelerations = np.gradient(true[-1100:, 1:], PERIOD, axis=0)
        lags = -np.sum(errors["fitted"] * accelerations, axis=0) / np.sum(accelerations**2, axis=0)
        assert np.abs(lags).max() < 2e-4


@pytest.mark.parametrize("effect", known_effects(), ids=lambda effect: effect.key)
def test_a_rig_that_is_as_the_model_says_is_followed(effect):
    once = effect.at_an_instant
    motion_model = PAPER.motion.with_effect(ActiveEffect(effect, 0 if once else None))
    values = [*PAPER.values, *(p.typical for p in effect.parameters if not p.fixed)]
    model = replace(PAPER, motion=motion_model, values=np.array(values), trials=("once",) * once)
    times, start = PERIOD * np.arange(100), np.array([2.0, 2.5, 0.0, 0.0])
    shown = MotionStream(model, start).readings(times)
    found = followed(Observer(model), times, joints(0.0 * times, shown))
    true = simulate(
        model.coefficients, start, times, effects=motion_model.acting(model.values, model.trial()).without_directions()
    )
    assert np.abs(found[20:] - joints(0.0 * times, true[:, 2:])[23:]).max() < 0.02


def test_nothing_is_said_after_a_gap_nor_after_a_step_back_of_time_nor_of_what_no_rig_does():
    times, positions, _ = moved("swing", 1.0)
    observer = Observer(MODEL)
    for since in (0.0, 10.0, 5.0, 5.0):
        followed(observer, times + since, positions)
    followed(observer, times + 6.5, np.random.default_rng(0).uniform(-1e3, 1e3, positions.shape))
    followed(observer, times + 16.0, positions)
