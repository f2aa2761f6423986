"""Twins: trials of a pendulum whose parameters are known, measured as a real rig measures."""

from collections.abc import Mapping

import numpy as np
import sympy

from cdp_ident.trial.trial import Trial
from reference.pendulum import AT_REST, TABLE_3, TABLE_5, Array, Torque, cart_position, motion

TEN_SECONDS = np.arange(2000) / 200.0
"""The paper's trial: 10 s at 200 Hz [s]."""


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
        tolerance: of the integration; see `motion`.
        name: the trial's.
    """
    theta = motion(values, start, times, cart, torque, tolerance)[:, :2]
    theta = theta + rng.normal(scale=noise, size=theta.shape)
    if counts_per_turn is not None:
        count = 2.0 * np.pi / counts_per_turn
        joints = np.diff(theta, axis=1, prepend=0.0)
        theta = np.cumsum(np.round(joints / count) * count, axis=1)
    position = None if cart == AT_REST else cart_position(cart, times)
    return Trial(name, times - times[0], theta, position)
