"""How long a motion is predictable: how long a simulation follows it before the initial state's error is too large.

Errors of an initial state grow by the equations of motion linearised along the motion (finite-time Lyapunov growth:
Benettin et al., Meccanica 15, 1980). The measured motion is used for that, so that nothing has to be simulated.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.smoothing import SmoothMotion
from cdp_ident.model.parameters import coefficients_of
from cdp_ident.model.trajectory import accelerations_at

Array = npt.NDArray[np.float64]

LOST = 0.2
"""An error of the angles, as a share of their scatter, beyond which a simulation no longer follows the motion: below
it, the motion is still nearly linear in corrections of the initial state."""
_QUANTILE = 0.1
"""Quantile over instants: from nine of ten the motion is predictable for at least the time returned."""
_APART = 10
"""Points of the motion's grid between the instants that are looked at."""
_NEAR = 2
"""The shortest time of so many neighbouring instants counts: the growth of errors varies from one to the next."""
_NUDGE = 1e-6


@dataclass(frozen=True)
class Predictability:
    """For how long a motion is predictable from initial states that are estimated by local cubics."""

    time: Array
    """(k,) instants [s]."""
    lasts: Array
    """(k,) how long it is predictable from each [s]."""

    def at(self, time: float) -> float:
        """Return for how long it is predictable from a time and from near it [s]."""
        at = int(np.argmin(np.abs(self.time - time)))
        return float(np.min(self.lasts[max(at - _NEAR, 0) : at + _NEAR + 1]))

    @property
    def mostly(self) -> float:
        """How long it is predictable from most of the instants [s]."""
        return float(np.quantile(self.lasts, _QUANTILE, method="lower"))


def predictability(
    motion: SmoothMotion,
    groups: Array,
    length: float,
    gravity: float,
    noise: Array,
    spacing: float,
    half_width: float,
    longest: float,
) -> Predictability:
    """Return for how long a motion is predictable from initial states that are estimated by local cubics.

    Args:
        motion: the smooth motion.
        groups: (5,) rough values of the base parameters.
        length: L [m].
        gravity: g [m/s^2].
        noise: (2,) standard deviation of the noise of the angles [rad].
        spacing: of the samples [s].
        half_width: of the local cubics [s].
        longest: longest time that is asked for [s].
    """
    time = motion.time[motion.known]
    angles, rates = motion.values[0][motion.known][:, :2], motion.rates[0][motion.known][:, :2]
    count = len(angles)
    if count < 2:
        return Predictability(motion.time[:1], np.zeros(1))
    steps = _steps(np.concatenate([angles, rates], axis=1), coefficients_of(groups, length, gravity), motion.spacing)
    # Variances of a local cubic's value and slope in its middle, from samples so far apart (Savitzky and Golay, 1964).
    samples = max(2.0 * half_width / spacing, 6.0)
    of_angle, of_rate = 9.0 / 4.0 / samples, 75.0 / 4.0 / (samples * half_width**2)
    start = np.concatenate([noise * np.sqrt(of_angle), noise * np.sqrt(of_rate)])
    amplitude = np.minimum(np.std(angles, axis=0), 1.0)
    begins = np.arange(0, count - 1, _APART)
    error = np.broadcast_to(np.diag(start), (len(begins), 4, 4)).copy()
    lasts = np.full(len(begins), longest)
    on = np.arange(len(begins))
    for step in range(min(count - 1, int(longest / motion.spacing))):
        on = on[begins[on] + step < count - 1]
        error[on] = steps[begins[on] + step] @ error[on]
        share = np.sqrt(np.sum(error[on, :2] ** 2, axis=2)) / amplitude
        lost = share.max(axis=1) > LOST
        lasts[on[lost]] = (step + 1) * motion.spacing
        on = on[~lost]
        if len(on) == 0:
            break
    return Predictability(time[begins], lasts)


def _steps(states: Array, coefficients: Array, spacing: float) -> Array:
    """Return what each step (m, 4, 4) does to an error of the state."""
    nothing = np.zeros(len(states))
    slope = np.zeros((len(states), 4, 4))
    slope[:, :2, 2:] = np.eye(2)
    for k in range(4):
        sides = []
        for sign in (1.0, -1.0):
            moved = states.copy()
            moved[:, k] += sign * _NUDGE
            sides.append(accelerations_at(coefficients, moved, nothing))
        slope[:, 2:, k] = (sides[0] - sides[1]) / (2.0 * _NUDGE)
    # In time units of a state with speeds of about one, three terms of the exponential hold to a thousandth.
    turn = spacing * slope
    square = turn @ turn
    return np.asarray(np.eye(4) + turn + square / 2.0 + square @ turn / 6.0)
