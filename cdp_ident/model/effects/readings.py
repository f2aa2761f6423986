"""From the motion of the rods to the angles that the encoders show."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.effect import SensorEffect

Array = npt.NDArray[np.float64]
Motion = Callable[[float], tuple[Array, Array]]
"""From a delay [s] to the states (n, 4) so much earlier and their derivatives (n, 4, d); without any, d is 0."""

_ENCODERS = ("inner", "outer")


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
    # The inner encoder turns by theta1, the outer one by theta2 - theta1.
    angles = [states[:, 0], states[:, 1] - states[:, 0]]
    slopes = [derivatives[:, 0], derivatives[:, 1] - derivatives[:, 0]]
    for effect, values, place in sensors:
        if effect.delays:
            late_states, late = motion(values[0]) if values[0] else (states, derivatives)
            angles[1], slopes[1] = late_states[:, 1] - late_states[:, 0], late[:, 1] - late[:, 0]
            if late.shape[2]:
                slopes[1][:, first + place.start] = late_states[:, 2] - late_states[:, 3]
    readings, by_directions = list(angles), [slope.copy() for slope in slopes]
    for effect, values, place in sensors:
        if effect.delays:
            continue
        k = _ENCODERS.index(effect.joint)
        added, by = effect.reading(angles[k], time, np.asarray(values))
        readings[k] = readings[k] + added
        if derivatives.shape[2]:
            by_directions[k] += by[:, :1] * slopes[k]
            by_directions[k][:, first + place.start : first + place.stop] += by[:, 1:]
    return (
        np.stack([readings[0], readings[0] + readings[1]], axis=1),
        np.stack([by_directions[0], by_directions[0] + by_directions[1]], axis=1),
    )
