"""How long a motion is predictable: how long a simulation follows it before the initial state's error is too large.

Errors of an initial state grow by the equations of motion linearised along the motion (finite-time Lyapunov growth:
Benettin et al., Meccanica 15, 1980). The measured motion is used for that, so that nothing has to be simulated.
"""

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.error_growth import steps_until
from cdp_ident.fit.smoothing import SmoothMotion
from cdp_ident.model.parameters import coefficients_of

Array = npt.NDArray[np.float64]

LOST = 0.2
"""An error of the angles, as a share of their scatter, beyond which a simulation no longer follows the motion: below
it, the motion is still nearly linear in corrections of the initial state."""
_QUANTILE = 0.1
"""Quantile over instants: from nine of ten the motion is predictable for at least the time returned."""
_APART = 10
"""Points of the motion's grid between the instants that are looked at."""


def predictability(
    motion: SmoothMotion,
    groups: Array,
    length: float,
    gravity: float,
    noise: Array,
    spacing: float,
    half_width: float,
    longest: float,
) -> float:
    """Return for how long a motion is predictable from most of its instants [s], by states of local cubics there.

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
    angles, rates = motion.values[0][motion.known][:, :2], motion.rates[0][motion.known][:, :2]
    count = len(angles)
    if count < 2:
        return 0.0
    # Variances of a local cubic's value and slope in its middle, from samples so far apart (Savitzky and Golay, 1964).
    samples = max(2.0 * half_width / spacing, 6.0)
    of_angle, of_rate = 9.0 / 4.0 / samples, 75.0 / 4.0 / (samples * half_width**2)
    start = np.concatenate([noise * np.sqrt(of_angle), noise * np.sqrt(of_rate)])
    amplitude = np.minimum(np.std(angles, axis=0), 1.0)
    begins = np.arange(0, count - 1, _APART)
    states, coefficients = np.concatenate([angles, rates], axis=1), coefficients_of(groups, length, gravity)
    count = min(int(longest / motion.spacing), count - 1)
    lost = steps_until(states, coefficients, motion.spacing, begins, start, LOST * amplitude, count)
    lasts = np.where(lost > 0, lost * motion.spacing, longest)
    return float(np.quantile(lasts, _QUANTILE, method="lower"))
