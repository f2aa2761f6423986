# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Angles and angular velocities from measured angles, by local polynomials."""

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
_FEWEST = 6
_LOOKED_AT = 2000
_POINTS_AT_ONCE = 4096


def local_motion(time: Array, theta: Array, at: Array, half_width: float = HALF_WIDTH) -> tuple[Array, Array]:
    """Estimate the motion at given times from measured angles, each from its neighbourhood alone.

    Args:
        time: (n,) times of the samples [s], strictly increasing, of any spacing.
        theta: (n, k) measured angles [rad].
        at: (m,) times at which to estimate [s], ascending, inside the measured time.
        half_width: samples no further away than this are used, shifted inwards at the ends of the measurement [s],
            and at least six.

    Returns:
        Angles (m, k) [rad] and angular velocities (m, k) [rad/s] of the least-squares cubic about each time
        (Savitzky and Golay, Anal. Chem. 36, 1964, for samples of any spacing).

    Raises:
        TrialError: there are fewer than six samples.
    """
    time, theta, at = (np.ascontiguousarray(values, dtype=float) for values in (time, theta, at))
    if len(time) < _FEWEST:
        raise TrialError(f"there are only {len(time)} samples; velocities need at least {_FEWEST}")
    centre = np.clip(at, time[0] + half_width, max(time[-1] - half_width, time[0] + half_width))
    first = np.searchsorted(time, centre - half_width - 1e-9)
    last = np.searchsorted(time, centre + half_width + 1e-9)
    lacking = np.maximum(_FEWEST - (last - first), 0)
    first = np.clip(first - (lacking + 1) // 2, 0, len(time) - _FEWEST)
    last = np.clip(np.maximum(last, first + _FEWEST), _FEWEST, len(time))
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
    solution = np.asarray(np.linalg.solve(transposed @ basis, transposed @ theta[index]))
    return solution[:, 0], np.asarray(solution[:, 1] / scale[:, None])


def off_smooth(time: Array, angles: Array, half_width: float) -> Array:
    """Return how far two thousand of some angles (n, k) are from smooth motion (m, k), in which they are left out.

    It is that of `local_motion` by samples no further away than `half_width` [s].
    """
    some = slice(None, None, max(1, len(time) // _LOOKED_AT))
    smooth, _ = local_motion(time, angles, time[some], half_width)
    together = max(_FEWEST, 2.0 * half_width * len(time) / (time[-1] - time[0]))
    return np.asarray(np.abs(angles[some] - smooth) / np.sqrt(1.0 - _CUBIC_AT_CENTRE / together))
