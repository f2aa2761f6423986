# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How long a motion is predictable: how long a simulation follows it before the initial state's error is too large.

Errors of an initial state grow by the equations of motion linearised along the motion (finite-time Lyapunov growth:
Benettin et al., Meccanica 15, 1980). The measured motion is used for that, so that nothing has to be simulated.
"""

import numpy as np
import numpy.typing as npt

from cdp_ident.model.motions import jacobians_at
from cdp_ident.model.parameters import coefficients_of
from cdp_ident.trial.weak_form import Motion

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

LOST = 0.2
"""An error of the angles, as a share of their scatter, beyond which a simulation no longer follows the motion: below
it, the motion is still nearly linear in corrections of the initial state."""
_QUANTILE = 0.1
"""Quantile over instants: from nine of ten the motion is predictable for at least the time returned."""
_TERMS = 3
"""Of the exponential from one point of the grid to the next: in time units of a state with speeds of about one, they
hold to a thousandth."""
_APART = 5
"""Points of the motion's grid between the instants that are looked at."""


def predictability(
    motion: Motion,
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
        motion: on a grid.
        groups: (5,) rough values of the base parameters.
        length: L [m].
        gravity: g [m/s^2].
        noise: (2,) standard deviation of the noise of the angles [rad].
        spacing: of the samples [s].
        half_width: of the local cubics [s].
        longest: longest time that is asked for [s].
    """
    states, count, step = np.concatenate([motion.angles, motion.rates], axis=1), len(motion.time), motion.scales.spacing
    if count < 2:
        return 0.0
    # Variances of a local cubic's value and slope in its middle, from samples so far apart (Savitzky and Golay, 1964).
    samples = max(2.0 * half_width / spacing, 6.0)
    of_angle, of_rate = 9.0 / 4.0 / samples, 75.0 / 4.0 / (samples * half_width**2)
    start = np.concatenate([noise * np.sqrt(of_angle), noise * np.sqrt(of_rate)])
    amplitude = np.minimum(np.std(motion.angles, axis=0), 1.0)
    begins = np.arange(0, count - 1, _APART)
    coefficients, most = coefficients_of(groups, length, gravity), min(int(longest / step), count - 1)
    lost = _steps_until(states, coefficients, step, begins, start, LOST * amplitude, most)
    lasts = np.where(lost > 0, lost * step, longest)
    return float(np.quantile(lasts, _QUANTILE, method="lower"))


def _steps_until(
    states: Array, coefficients: Array, spacing: float, begins: Indices, error: Array, limits: Array, most: int
) -> Indices:
    """Return after how many steps (k,) an error of the state is beyond a limit; 0 where it never is.

    Args:
        states: (n, 4) theta1, theta2 [rad], omega1, omega2 [rad/s] of the motion, evenly spaced, cart at rest.
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        spacing: of the states [s].
        begins: (k,) indices of the states that have the error, ascending.
        error: (4,) its standard deviations, independent of each other.
        limits: (2,) of the standard deviation of each angle [rad].
        most: steps after which nobody asks.
    """
    by_state = np.zeros((len(states) - 1, 4, 4))
    by_state[:, :2, 2:], by_state[:, 2:] = np.eye(2), jacobians_at(coefficients, states[:-1])
    carried = term = np.broadcast_to(np.eye(4), by_state.shape)
    for order in range(1, _TERMS + 1):
        term = spacing / order * by_state @ term
        carried = carried + term
    lost, errors = np.zeros(len(begins), dtype=np.int64), np.tile(np.diag(error), (len(begins), 1, 1))
    for step in range(most):
        going = np.flatnonzero((lost == 0) & (begins + step < len(carried)))
        errors[going] = carried[begins[going] + step] @ errors[going]
        beyond = np.any(np.sum(errors[going, :2] ** 2, axis=2) > limits**2, axis=1)
        lost[going[beyond]] = step + 1
    return lost
