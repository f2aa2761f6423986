# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whole swings of a pendulum whose parameters are known, as the likelihood takes them."""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np
from scipy.signal import lfilter

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import NEAR
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.recorded import states_of
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.trial.trial import Trial
from reference import sticking
from reference.dry_friction import DryFriction
from reference.pendulum import TABLE_2, TABLE_5, Array

MODEL = MotionModel(Mechanism(0.4, 9.81, 0.4, 0.03))
UNIT = math.sqrt(0.4 / 9.81)
"""Time unit of the rig [s]."""
TRUE, BEGIN = (groups_of(np.array([table[s] for s in SYMBOLS]), 0.4) for table in (TABLE_5, TABLE_2))
STEP = 0.005
TIME: Array = np.asarray(np.linspace(0.0, 8.0, 1600, endpoint=False), dtype=np.float64)
NOISE = 2.3e-4
"""Of both encoders [rad]."""


def known(key: str) -> Effect:
    """Return the catalogue's effect of a key."""
    return next(effect for effect in known_effects() if effect.key == key)


@cache
def motion(start: tuple[float, float] = (1.5, 1.2), dry: float = 0.0) -> Array:
    """Return angles (n, 2) of a swing from rest [rad], with dry friction in the outer joint [N m]."""
    return sticking.motion(TABLE_5, [*start, 0.0, 0.0], TIME, outer=DryFriction(dry))[:, :2]


def measured(
    angles: Array, rng: np.random.Generator, noise: float = NOISE, memory: float = 0.0, time: Array = TIME
) -> Trial:
    """Return what encoders without counts show of angles (n, 2); noise is a first-order autoregression."""
    errors = rng.normal(size=angles.shape) * np.r_[1.0, np.full(len(angles) - 1, math.sqrt(1.0 - memory**2))][:, None]
    errors = lfilter([1.0], [1.0, -memory], errors, axis=0)
    readings = np.diff(angles, axis=1, prepend=0.0) + noise * errors
    return Trial("swing", time, np.cumsum(readings, axis=1))


def recorded(trials: Sequence[Trial], spacing: float = NEAR, steps: float = 0.0) -> Recorded:
    """Return trials with nodes of a spacing in time units, and encoders of a step [rad]."""
    counts = np.full(2, steps)
    swings = [s for k, one in enumerate(trials) for s in Swing.of(one, k, STEP, spacing * UNIT)]
    return Recorded(tuple(swings), np.full(2, 3e-4), counts, UNIT)


def fitted(
    of: Recorded, model: MotionModel = MODEL, values: Array = TRUE, start: WholeSwings | None = None
) -> WholeSwings:
    """Return a model fitted to what was recorded, by default from readings and large torques."""
    states = start.states if start else states_of(of, model)
    noise = start.noise if start else Noise.white(of.encoders, of.large_torque)
    return GaussNewton(model, values, of, states, noise).run().found()


def with_effect(found: WholeSwings, key: str, *values: float, trial: int | None = None) -> WholeSwings:
    """Return a fitted model with an effect more, fitted from given values of its parameters."""
    model = found.model.with_effect(ActiveEffect(known(key), trial=trial))
    return fitted(found.recorded, model, np.concatenate([found.values, values]), found)
