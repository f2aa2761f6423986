# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The noise of the measured angles, estimated from them alone, by differences of samples that follow one another."""

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.trial.kinematics import MEDIAN_OF_SIZE, SAME, encoder_step, fourth_differences
from cdp_ident.trial.trial import Trial

_STANDS_OUT = 4.0
"""Differences beyond so many standard deviations are not noise but impulses or outliers."""
_GROWS = 2.5
"""Fourth differences of samples twice as far apart show at most so many times as much of noise: as much of white noise,
1.4 times as much of a random walk; but 2.8 times as much where random torques move rods, 9 to 16 of smooth motion."""


def noise_of(trial: Trial) -> Array:
    """Return the standard deviation of the noise of theta1 and theta2 [rad].

    It is that of fourth divided differences, scaled so that white noise of standard deviation 1 gives 1, without those
    that are not noise. Of noise that is remembered from one sample to the next, samples further apart show more: twice
    as far each time, as long as those twice as far again show noise. Where the motion is slow, an encoder repeats its
    readings and the differences are zero; therefore the noise is never estimated below that of quantisation, the step
    over the square root of 12, of which theta2 has both encoders'.
    """
    shown, apart = _deviations(trial, 1), 1
    is_noise: Mask = np.full(2, True)
    found = np.maximum(shown, _rounding(encoder_steps(trial)))
    while np.any(is_noise) and 16 * apart < len(trial.time):
        further = _deviations(trial, 2 * apart)
        is_noise = is_noise & (further < _GROWS * shown)
        found = np.where(is_noise, np.maximum(found, shown), found)
        shown, apart = further, 2 * apart
    return found


def _deviations(trial: Trial, apart: int) -> Array:
    """Return the standard deviations (2,) that differences of samples so many apart show of theta1 and theta2 [rad]."""
    sizes = np.abs(fourth_differences(trial.time, trial.theta, apart))
    return np.array([_trimmed_deviation(column) for column in sizes.T])


def rounding_of_averages(trial: Trial, together: int) -> Array:
    """Return a lower limit (2,) of the root mean square error that rounding leaves in averages [rad].

    Where an encoder repeats its reading over two averages, both have its whole error, and their differences do not show
    it; where readings change, errors average out, and differences show the rest.

    Args:
        trial: as it was measured.
        together: how many of its samples are averaged into one.
    """
    span = 2 * together
    count = len(trial.time) // span
    angles = _encoder_angles(trial)[: count * span].reshape(count, span, 2)
    repeats = np.all(np.abs(np.diff(angles, axis=1)) <= SAME, axis=1)
    return _rounding(encoder_steps(trial) * np.sqrt(np.mean(repeats, axis=0)))


def encoder_steps(trial: Trial) -> Array:
    """Return the steps (2,) of the inner and the outer encoder, 0 where none shows [rad]."""
    return np.array([encoder_step(angle) for angle in _encoder_angles(trial).T])


def _encoder_angles(trial: Trial) -> Array:
    """Return the angles (n, 2) of the inner and the outer encoder [rad]."""
    theta1, theta2 = trial.theta.T
    return np.column_stack([theta1, theta2 - theta1])


def _rounding(steps: Array) -> Array:
    """Return the root mean square error (2,) of theta1 and theta2 by encoders' steps (2,): theta2 has both [rad]."""
    return np.asarray(np.sqrt(np.cumsum(steps**2) / 12.0))


def _trimmed_deviation(sizes: Array) -> float:
    """Return the root mean square of differences of which the sizes are given, without those that stand out.

    Where an encoder mostly repeats its reading, the differences that are not zero are single steps, not outliers.
    """
    shown = sizes[sizes > SAME]
    usual = float(np.median(shown)) / MEDIAN_OF_SIZE if len(shown) else 0.0
    return float(np.sqrt(np.mean(sizes[sizes <= _STANDS_OUT * usual + SAME] ** 2)))
