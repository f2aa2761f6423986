"""An inner rod that bends under the outer one, so that neither encoder turns by the line between the joints.

A cantilever with a force F across its end leaves that line by a slope of F L^2 / (3 E I) at its root, where the inner
encoder is, and by half of that at its end, where the outer one is (Euler and Bernoulli; Timoshenko, Strength of
Materials, 1955). F is what accelerates all that hangs there, whatever torques the joints have::

    F = -(m2 + m0) (L theta1'' - g sin theta1 + u cos theta1)
        - m2 l2 (cos(theta1 - theta2) theta2'' + sin(theta1 - theta2) theta2'^2)

So the slope at the root is linear in two parameters, which need no masses: what it is of a rod held level, by the
weight of m2 + m0 (`sag`), and m2 l2 / ((m2 + m0) L) of it (`swing`). The bending itself is taken to be quasi-static.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.effect import EffectParameter, SensorEffect

Array = npt.NDArray[np.float64]
Motion = Callable[[float], tuple[Array, Array]]
"""From a delay [s] to the states (n, 4 or more) so much earlier and the derivatives (n, 2, d) of their angles; without
any, d is 0."""

_AT_END = 0.5
"""Slope at the end of the rod over that at its root, to the other side of the line between the joints."""
_AHEAD = 5e-4
"""Step of the differences along the motion that give the derivatives' own rates of change [s]."""

ROD_FLEX = SensorEffect(
    "rod_flex",
    "inner",
    "",
    "a rod that bends",
    "angle + bend, the outer encoder's + bend/2; bend = sag (L theta1''/g - sin theta1 + u cos theta1/g) "
    "+ swing L/g (cos(theta1 - theta2) theta2'' + sin(theta1 - theta2) theta2'^2)",
    "cantilever with a force across its end: Timoshenko, Strength of Materials, 1955",
    (
        EffectParameter("sag", "rad", 0.0, 0.3, 0.01),
        EffectParameter("swing", "rad", 0.0, 0.3, 0.005),
    ),
    law=None,
    bends=True,
)


@dataclass(frozen=True)
class Load:
    """What the force across the end of the inner rod follows from."""

    length: float
    """L [m]."""
    gravity: float
    """g [m/s^2]."""
    accelerations: Callable[[Array, float], tuple[Array, Array]]
    """From states (n, 4 or more), and how much earlier than the samples they are [s], to theta1'', theta2'' (n, 2)
    [rad/s^2] and the cart's acceleration (n,) [m/s^2]."""


def bends(states: Array, accelerations: Array, u: Array, length: float, gravity: float) -> Array:
    """Return the slope at the root of the rod (n, 2), by a `sag` of 1 and by a `swing` of 1.

    Args:
        states: (n, 4 or more) theta1, theta2 [rad], omega1, omega2 [rad/s].
        accelerations: (n, 2) theta1'', theta2'' [rad/s^2].
        u: (n,) the cart's acceleration [m/s^2].
        length: L [m].
        gravity: g [m/s^2].
    """
    across = states[:, 0] - states[:, 1]
    end = length * accelerations[:, 0] - gravity * np.sin(states[:, 0]) + u * np.cos(states[:, 0])
    outer = np.cos(across) * accelerations[:, 1] + np.sin(across) * states[:, 3] ** 2
    return np.stack([end / gravity, outer * (length / gravity)], axis=1)


def turned_along(angles: Array, bend: Array) -> None:
    """Add to absolute angles (n, 2, …) that encoders show, or what goes with these, what a slope (n, …) makes of it."""
    angles[:, 0] += bend
    angles[:, 1] += (1.0 + _AT_END) * bend


def bent(motion: Motion, load: Load, values: Sequence[float] | Array, first: int) -> Motion:
    """Return a motion as encoders on a rod that bends are turned by it.

    Args:
        motion: that of the line between the joints, and of the outer rod.
        load: what bends the rod.
        values: `sag` and `swing` [rad].
        first: direction of `sag` among those of the derivatives.
    """
    strengths = np.asarray(values, dtype=float)

    def slopes(states: Array, delay: float) -> tuple[Array, Array, Array]:
        accelerations, u = load.accelerations(states, delay)
        return bends(states, accelerations, u, load.length, load.gravity), accelerations, u

    def shown(delay: float) -> tuple[Array, Array]:
        states, derivatives = motion(delay)
        by_strength, accelerations, u = slopes(states, delay)
        turned = states.copy()
        turned_along(turned, by_strength @ strengths)
        if not derivatives.shape[2]:
            return turned, derivatives
        derivatives = derivatives.copy()
        by_direction = np.zeros_like(derivatives[:, 0])
        if strengths.any():
            (before, by_before), (after, by_after) = motion(delay + _AHEAD), motion(delay - _AHEAD)
            faster = slopes(after, delay - _AHEAD)[0] - slopes(before, delay + _AHEAD)[0]
            turned_along(turned[:, 2:], faster @ strengths / (2.0 * _AHEAD))
            rates = (by_after - by_before) / (2.0 * _AHEAD)
            seconds = (by_after - 2.0 * derivatives + by_before) / _AHEAD**2
            by_direction += _along(states, accelerations, u, derivatives, rates, seconds, load, strengths)
        by_direction[:, first : first + 2] += by_strength
        turned_along(derivatives, by_direction)
        return turned, derivatives

    return shown


def _along(
    states: Array,
    accelerations: Array,
    u: Array,
    angles: Array,
    rates: Array,
    seconds: Array,
    load: Load,
    values: Array,
) -> Array:
    """Return the derivatives (n, d) of the slope, given those of the angles, speeds and accelerations (n, 2, d).

    Those by L and g are without the slope's own dependence on these.
    """
    sag, swing = values / load.gravity
    theta1, across, omega2 = states[:, 0, None], (states[:, 0] - states[:, 1])[:, None], states[:, 3, None]
    sine, cosine, turning = np.sin(across), np.cos(across), angles[:, 0] - angles[:, 1]
    down = load.gravity * np.cos(theta1) + u[:, None] * np.sin(theta1)
    of_end = load.length * seconds[:, 0] - down * angles[:, 0]
    of_outer = cosine * seconds[:, 1] + 2.0 * omega2 * sine * rates[:, 1]
    of_outer += (cosine * omega2**2 - sine * accelerations[:, 1, None]) * turning
    return np.asarray(sag * of_end + swing * load.length * of_outer)
