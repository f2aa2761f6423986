# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials of one rig that motors in the joints, or its cart, drive."""

import numpy as np
import sympy

from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5, TIME, Array, cart_position, motion

TIMES: Array = np.asarray(np.arange(0.0, 8.0, 0.005), dtype=float)
NOISE, CART_NOISE = 2e-4, 5e-5
"""Standard deviations of the encoders' noise [rad] and of the cart's position [m]."""
FRICTION = 2e-3
"""Quadratic friction in the outer joint, which the paper's model lacks [N m s^2]."""
START = np.array([np.pi + 0.5, np.pi - 0.4, 0.0, 0.0])


def driven_by_motors(seed: int, lag: float = 0.0) -> Trial:
    """Return a trial with motors in both joints, whose torques act a lag [s] after their record."""
    rng = np.random.default_rng(seed)
    frequencies, phases = rng.uniform(0.3, 3.0, (2, 4)), rng.uniform(0.0, 2.0 * np.pi, (2, 4))
    sizes = rng.uniform(0.3, 1.0, (2, 4)) * np.array([[0.08], [0.03]])

    def torques(time: float) -> Array:
        return np.asarray(np.sum(sizes * np.sin(2.0 * np.pi * frequencies * time + phases), axis=1))

    def acting(time: float, state: Array) -> tuple[float, float]:
        inner, outer = torques(time - lag)
        outer += _friction(state)
        return inner - outer, outer

    theta = motion(TABLE_5, START, TIMES, torque=acting, tolerance=1e-10)[:, :2]
    return Trial(
        f"driven {seed}", TIMES, _measured(theta, rng), torques=np.array([torques(at) for at in TIMES.tolist()])
    )


def driven_by_cart(seed: int, times: Array = TIMES) -> Trial:
    """Return a trial whose cart is driven, and measured at times (n,) [s]."""
    rng = np.random.default_rng(seed)
    cart = 0.06 * sympy.sin(2.3 * TIME + seed) + 0.03 * sympy.sin(5.1 * TIME)

    def acting(_time: float, state: Array) -> tuple[float, float]:
        return -_friction(state), _friction(state)

    theta = motion(TABLE_5, START, times, cart, acting, tolerance=1e-10)[:, :2]
    position = cart_position(cart, times) + CART_NOISE * rng.normal(size=len(times))
    return Trial(f"cart {seed}", times, _measured(theta, rng), cart=position)


def _friction(state: Array) -> float:
    speed = float(state[3] - state[2])
    return -FRICTION * speed * abs(speed)


def _measured(theta: Array, rng: np.random.Generator) -> Array:
    joints = np.diff(theta, axis=1, prepend=0.0)
    return np.asarray(np.cumsum(joints + NOISE * rng.normal(size=joints.shape), axis=1))
