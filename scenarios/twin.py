# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Twins: trials of a pendulum whose parameters are known, measured as a real rig measures."""

import functools
from collections.abc import Mapping

import numpy as np
import sympy

from cdp_ident.trial.trial import Trial
from reference import sticking
from reference.pendulum import AT_REST, TABLE_3, TABLE_5, Array, Torque, cart_position, motion

TEN_SECONDS = np.arange(2000) / 200.0
"""The paper's trial: 10 s at 200 Hz [s]."""


def as_measured(
    theta: Array, rng: np.random.Generator, noise: float = 2e-3, counts_per_turn: int | None = 8000
) -> Array:
    """Return what encoders show of the angles theta1, theta2 (n, 2) [rad]; see `twin`."""
    theta = theta + rng.normal(scale=noise, size=theta.shape)
    if counts_per_turn is None:
        return theta
    count = 2.0 * np.pi / counts_per_turn
    joints = np.diff(theta, axis=1, prepend=0.0)
    return np.asarray(np.cumsum(np.round(joints / count) * count, axis=1))


@functools.cache
def standard_motion() -> Array:
    """Return the angles (n, 2) of the twin of the paper's trial before any noise [rad], made once and read-only."""
    theta = sticking.motion(TABLE_5, TABLE_3, TEN_SECONDS)[:, :2]
    theta.setflags(write=False)
    return theta


def standard_twin(rng: np.random.Generator) -> Trial:
    """Return the same as `twin(rng)`, the motion of which is made only once."""
    return Trial("twin", TEN_SECONDS, as_measured(standard_motion(), rng))


def twin(
    rng: np.random.Generator,
    values: Mapping[str, float] = TABLE_5,
    start: tuple[float, float, float, float] | Array = TABLE_3,
    times: Array = TEN_SECONDS,
    *,
    noise: float = 2e-3,
    counts_per_turn: int | None = 8000,
    cart: sympy.Expr = AT_REST,
    torque: Torque | None = None,
    tolerance: float = 1e-11,
    name: str = "twin",
) -> Trial:
    """Return what a rig would have measured of a motion.

    Args:
        rng: where the noise comes from.
        values: physical values of all `SYMBOLS`.
        start: (4,) state at time 0: theta1, theta2 [rad], omega1, omega2 [rad/s].
        times: (n,) ascending times of the samples from 0 on [s].
        noise: standard deviation of what is added to theta1 and theta2 before they are counted [rad].
        counts_per_turn: resolution of both encoders, the outer one of which sits between the rods; None for none.
        cart: the cart's position [m] as an expression of `TIME`; measured where it is not at rest.
        torque: a hidden effect; see `motion`.
        tolerance: of the integration over a cart that moves or with a hidden effect; see `motion`.
        name: the trial's.
    """
    if torque is None and cart == AT_REST and times[0] == 0.0:
        states = sticking.motion(values, start, times)  # compiled, and the same to 1e-9
    else:
        states = motion(values, start, times, cart, torque, tolerance)
    theta = as_measured(states[:, :2], rng, noise, counts_per_turn)
    position = None if cart == AT_REST else cart_position(cart, times)
    return Trial(name, times - times[0], theta, position)
