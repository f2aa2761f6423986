# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What neighbouring samples tell: angles and velocities, by local polynomials, and an encoder's noise and steps."""

import numpy as np
from numpy.polynomial.polynomial import polyvander

from cdp_ident.arrays import Array, Indices
from cdp_ident.errors import TrialError

HALF_WIDTH = 0.05
"""Samples this near [s] enter a local polynomial.

With 200 Hz and 2 mrad of noise the error of a velocity is then 0.04 rad/s, and the systematic error of a cubic for a
swing at 10 rad/s a tenth of that.
"""
_CUBIC_AT_CENTRE = 2.25
"""A cubic fitted to N samples follows the noise of the one in the middle by this over N."""
FEWEST = 6
"""Samples of a neighbourhood at least."""
_RIDGE = 1e-12
"""Added to the normal equations over times from -1 to 1, which are singular where all but a few samples coincide."""
_FAST = 0.9
"""Roughness is looked at where motion is fast, at this quantile: at rest, all times are as good."""
_FEWEST_OF_FAST = 30
_LOOKED_AT = 2000
_POINTS_AT_ONCE = 4096
SAMPLES = 5
"""Samples in a fourth divided difference, to which the pendulum's motion hardly contributes: at 200 Hz a swing at 10
rad/s of 1 rad leaves 6 microradians in it."""
SAME = 1e-9
"""Angles that differ by less are one reading [rad]."""
MEDIAN_OF_SIZE = 0.6745
"""Median of the size of a standard normal number."""
_OTHERS = 0.02
"""Least share of the changes that are not of one step: none, or of several."""


def local_motion(time: Array, theta: Array, at: Array, half_width: float = HALF_WIDTH) -> tuple[Array, Array]:
    """Return angles (m, k) [rad] and velocities (m, k) [rad/s] at some times (m,), each from its neighbourhood alone.

    They are those of the least-squares cubic (Savitzky and Golay, Anal. Chem. 36, 1964, for samples of any spacing)
    through the measured angles `theta` (n, k) no further away than `half_width` [s], shifted inwards at the ends of the
    measurement, and at least six. `time` (n,) [s] increases strictly, and `at` [s] is ascending and inside it.

    Raises:
        TrialError: there are fewer than six samples.
    """
    time, theta, at = (np.ascontiguousarray(values, dtype=float) for values in (time, theta, at))
    if len(time) < FEWEST:
        raise TrialError(f"there are only {len(time)} samples; velocities need at least {FEWEST}")
    centre = np.clip(at, time[0] + half_width, max(time[-1] - half_width, time[0] + half_width))
    first = np.searchsorted(time, centre - half_width - 1e-9)
    last = np.searchsorted(time, centre + half_width + 1e-9)
    lacking = np.maximum(FEWEST - (last - first), 0)
    first = np.clip(first - (lacking + 1) // 2, 0, len(time) - FEWEST)
    last = np.clip(np.maximum(last, first + FEWEST), FEWEST, len(time))
    angles, velocities = np.empty((len(at), theta.shape[1])), np.empty((len(at), theta.shape[1]))
    for begin in range(0, len(at), _POINTS_AT_ONCE):
        part = slice(begin, begin + _POINTS_AT_ONCE)
        angles[part], velocities[part] = _fit_cubics(time, theta, at[part], first[part], last[part])
    return angles, velocities


def _fit_cubics(time: Array, theta: Array, at: Array, first: Indices, last: Indices) -> tuple[Array, Array]:
    index = first[:, None] + np.arange((last - first).max())
    inside = index < last[:, None]
    index = np.minimum(index, len(time) - 1)
    # Times relative to the place asked for and scaled to about one keep the normal equations well conditioned.
    offset = np.where(inside, time[index] - at[:, None], 0.0)
    scale = np.abs(offset).max(axis=1)
    basis = inside[..., None] * polyvander(offset / scale[:, None], 3)
    transposed = basis.transpose(0, 2, 1)
    solution = np.asarray(np.linalg.solve(transposed @ basis + _RIDGE * np.eye(4), transposed @ theta[index]))
    return solution[:, 0], np.asarray(solution[:, 1] / scale[:, None])


def off_smooth(time: Array, angles: Array, half_width: float) -> Array:
    """Return how far two thousand of some angles (n, k) are from smooth motion (m, k), in which they are left out.

    It is that of `local_motion` by samples no further away than `half_width` [s].
    """
    some = slice(None, None, max(1, len(time) // _LOOKED_AT))
    smooth, _ = local_motion(time, angles, time[some], half_width)
    together = max(FEWEST, 2.0 * half_width * len(time) / (time[-1] - time[0]))
    return np.asarray(np.abs(angles[some] - smooth) / np.sqrt(1.0 - _CUBIC_AT_CENTRE / together))


def roughness(time: Array, angles: Array, half_width: float) -> float:
    """Return how far angles (n, k) are from cubics over twice the `half_width` [s] where that is much."""
    if len(time) < _FEWEST_OF_FAST:
        return np.inf
    off = off_smooth(time, np.asarray(np.unwrap(angles, axis=0)), half_width)
    return float(np.max(np.quantile(off, _FAST, axis=0)))


def fourth_differences(time: Array, values: Array, apart: int = 1) -> Array:
    """Return the fourth divided differences (m, ...) of values (n, ...) at times (n,), strictly increasing.

    They are of samples so many apart, n - 4 of them where these are neighbours, and scaled so that white noise of
    standard deviation 1 gives 1.
    """
    count, places = len(time) - apart * (SAMPLES - 1), apart * np.arange(SAMPLES)
    columns, stamps = values.reshape(len(time), -1), [time[at : at + count] for at in places]
    squares, differences = np.zeros(count), np.zeros((count, columns.shape[1]))
    for k, at in enumerate(places):
        weights = np.ones(count)
        for other in {*range(SAMPLES)} - {k}:
            weights /= stamps[k] - stamps[other]
        squares += weights**2
        differences += weights[:, None] * columns[at : at + count]
    differences /= np.sqrt(squares)[:, None]
    return differences.reshape(count, *values.shape[1:])


def encoder_step(angles: Array) -> float:
    """Return the step of the encoder that measured angles (n,) [rad], or 0 where none shows.

    All changes between samples are whole multiples of the step if there is one. Where all of them are about the same,
    as of a rod that turns evenly, none shows.
    """
    every = np.abs(np.diff(angles))
    changes = every[every > SAME]
    if len(changes) == 0:
        return 0.0
    smallest = float(changes.min())
    near = changes[changes < 1.5 * smallest]
    step = float(near.mean())
    multiples = changes[changes < 50 * step] / step
    whole = np.abs(multiples - np.round(multiples)) < 0.1
    others = np.mean(np.round(every / step) != 1.0)
    return step if len(near) >= 3 and np.mean(whole) > 0.95 and others > _OTHERS else 0.0
