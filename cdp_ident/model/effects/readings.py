"""From the motion of the rods to the angles that the encoders show."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.effect import JOINTS, SensorEffect

Array = npt.NDArray[np.float64]
Motion = Callable[[float], tuple[Array, Array]]
"""From a delay [s] to the states (n, 4) so much earlier and their derivatives (n, 4, d); without any, d is 0."""


def encoder_readings(
    motion: Motion, sensors: Sequence[tuple[SensorEffect, Sequence[float], slice]], time: Array, first: int
) -> tuple[Array, Array]:
    """Return the angles theta1, theta2 (n, 2) as the encoders show them, and their derivatives (n, 2, d).

    Where the motion comes without derivatives, there are none of the angles either.

    Args:
        motion: the rods' motion.
        sensors: the encoders' effects, with the values of all their parameters and the place of the fitted ones
            among the unknowns.
        time: (n,) time of each sample in the trial [s].
        first: direction of the first unknown among the d.
    """
    states, derivatives = motion(0.0)
    if not sensors:
        return states[:, :2], derivatives[:, :2]
    angles, slopes = [of_joint(states, k) for k in range(2)], [of_joint(derivatives, k) for k in range(2)]
    for effect, values, place in sensors:
        if effect.delays:
            k = JOINTS.index(effect.joint)
            late_states, late = motion(values[0]) if values[0] else (states, derivatives)
            angles[k], slopes[k] = of_joint(late_states, k), of_joint(late, k)
            if late.shape[2]:
                slopes[k][:, first + place.start] = -of_joint(late_states[:, 2:], k)
    readings, by_directions = list(angles), [slope.copy() for slope in slopes]
    for effect, values, place in sensors:
        if effect.delays:
            continue
        k = JOINTS.index(effect.joint)
        added, by = effect.reading(angles[k], time, np.asarray(values))
        readings[k] = readings[k] + added
        if derivatives.shape[2]:
            by_directions[k] += by[:, :1] * slopes[k]
            by_directions[k][:, first + place.start : first + place.stop] += by[:, 1:]
    return (
        np.stack([readings[0], readings[0] + readings[1]], axis=1),
        np.stack([by_directions[0], by_directions[0] + by_directions[1]], axis=1),
    )


def of_joint(values: Array, joint: int) -> Array:
    """Return what a joint has, which turns by theta1 or theta2 - theta1, of values (n, 2 or more, …) of both rods."""
    return values[:, 0].copy() if joint == 0 else values[:, 1] - values[:, 0]
