"""From the motion of the rods to the angles that the encoders show."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.effect import JOINTS, SensorEffect
from cdp_ident.model.effects.play import Turned

Array = npt.NDArray[np.float64]
Motion = Callable[[float], tuple[Array, Array]]
"""From a delay [s] to the states (n, 4 or more) so much earlier and the derivatives (n, 2, d) of their angles; without
any, d is 0."""


def encoder_readings(
    motion: Motion,
    sensors: Sequence[tuple[SensorEffect, Sequence[float], slice]],
    time: Array,
    first: int,
    shown: Array | None = None,
    turned: Turned | None = None,
) -> tuple[Array, Array]:
    """Return the angles theta1, theta2 (n, 2) as the encoders show them, and their derivatives (n, 2, d).

    Where the motion comes without derivatives, there are none of the angles either.

    Args:
        motion: the rods' motion.
        sensors: the encoders' effects, with the values of all their parameters and the place of the fitted ones
            among the unknowns.
        time: (n,) time of each sample in the trial [s], ascending.
        first: direction of the first unknown among the d.
        shown: (2,) theta1, theta2 as the encoders showed them at the first sample [rad], where that is known: it says
            where in its gap one with play is.
        turned: by what encoders with play were turned before, where these samples go on from others.
    """
    states, derivatives = motion(0.0)
    if not sensors:
        return states[:, :2], derivatives[:, :2]
    readings, by_directions = states[:, :2].copy(), derivatives[:, :2].copy()
    angles, slopes = [of_joint(states, k) for k in range(2)], [of_joint(derivatives, k) for k in range(2)]

    def add(k: int, angle: Array, slope: Array) -> None:
        """Add to what the encoder of a joint shows; both absolute angles contain the inner one's."""
        readings[:, k:] += angle[:, None]
        by_directions[:, k:] += slope[:, None]

    for effect, values, place in sensors:
        if effect.delays:
            k = JOINTS.index(effect.joint)
            late_states, late = motion(values[0]) if values[0] else (states, derivatives)
            angle, slope = of_joint(late_states, k), of_joint(late, k)
            if late.shape[2]:
                slope = slope.copy()
                slope[:, first + place.start] = -of_joint(late_states[:, 2:], k)
            add(k, angle - angles[k], slope - slopes[k])
            angles[k], slopes[k] = angle, slope
    turned = turned or Turned()
    for effect, values, place in sensors:
        if effect.has_play:
            k = JOINTS.index(effect.joint)
            before = (
                None if shown is None else _turned_by(of_joint(shown[None], k), k, sensors, angles[k][:1], time[:1])
            )
            followed = turned.follow(k, time, angles[k], values[0], before)
            slope = followed.slopes(slopes[k])
            if derivatives.shape[2]:
                slope[:, first + place.start] += followed.by_gap
            add(k, followed.angle - angles[k], slope - slopes[k])
            angles[k], slopes[k] = followed.angle, slope
    by_angle: list[Array | float] = [0.0, 0.0]
    for effect, values, place in sensors:
        if not (effect.delays or effect.has_play):
            k = JOINTS.index(effect.joint)
            added = effect.reading(angles[k], time, values)
            readings[:, k:] += np.reshape(added.angle, (-1, 1))
            by_angle[k] = by_angle[k] + added.by_angle
            if derivatives.shape[2]:
                for direction, by_parameter in enumerate(added.by_parameters, first + place.start):
                    by_directions[:, k:, direction] += np.reshape(by_parameter, (-1, 1))
    for k, factor in enumerate(by_angle):
        if derivatives.shape[2] and np.any(factor):
            by_directions[:, k:] += (np.reshape(factor, (-1, 1)) * slopes[k])[:, None]
    return readings, by_directions


def _turned_by(
    shown: Array,
    joint: int,
    sensors: Sequence[tuple[SensorEffect, Sequence[float], slice]],
    angle: Array,
    time: Array,
) -> float:
    """Return what an encoder is turned by that shows an angle (1,), without what its other effects add to it [rad]."""
    others = (effect.reading(angle, time, v).angle for effect, v, _ in sensors if effect.joint == JOINTS[joint])
    return float((shown - sum(others, np.zeros(1)))[0])


def of_joint(values: Array, joint: int) -> Array:
    """Return what a joint has, which turns by theta1 or theta2 - theta1, of values (n, 2 or more, …) of both rods."""
    return values[:, 0] if joint == 0 else values[:, 1] - values[:, 0]
