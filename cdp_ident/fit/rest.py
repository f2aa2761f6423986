# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Joints at rest: where they are, and how little the readings of their encoders say there."""

from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from cdp_ident.fit.noise import NO_STEPS

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_AT_REST = 1.5
"""A joint moves by fewer steps of its encoder at rest: its angle may be on the edge between two readings."""
READINGS = np.array([[1.0, 0.0], [-1.0, 1.0]])
"""What the inner and the outer encoder measure of theta1 and theta2."""
_REPEATED = 1e-9
"""Angles that differ by less are one reading [rad]."""
_ALONE = 0.15
"""Share of a window for which one joint alone must rest to count so: it also turns back while the other one moves."""


def weights_at_rest(time: Array, theta: Array, longest: float, steps: Array = NO_STEPS) -> Array | None:
    """Return the weights (n, 2) of both encoders' readings, where joints stand still; None where they do not.

    While an encoder repeats its reading, it repeats one error of rounding as well: all these readings together count as
    one.

    Args:
        time: (n,) of a window's samples [s].
        theta: (n, 2) measured angles [rad].
        longest: for which both readings may be repeated without the rods being at rest [s].
        steps: (2,) of the inner and the outer encoder [rad].
    """
    readings = theta @ READINGS.T
    moves = np.any(np.abs(np.diff(readings, axis=0)) > _REPEATED, axis=1)
    weight = np.ones(theta.shape)
    for rest in _long_ones(time, moves, longest):
        weight[rest] = 1.0 / (rest.stop - rest.start)
    for of_encoder, reading, step in zip(weight.T, readings.T, steps, strict=True):
        alone = _ALONE * (time[-1] - time[0])
        span = int(np.searchsorted(time, time[0] + alone)) | 1
        ranges = maximum_filter1d(reading, span) - minimum_filter1d(reading, span)
        rests = maximum_filter1d(ranges <= max(_AT_REST * step, _REPEATED), span)
        for rest in _long_ones(time, np.diff(rests) != 0, alone):
            if rests[rest.start]:
                of_encoder[rest] = np.minimum(of_encoder[rest], 1.0 / (rest.stop - rest.start))
    return weight if np.any(weight < 1.0) else None


def weights_of_runs(theta: Array) -> Array:
    """Return weights (n, 2) of both encoders' readings, of which all that repeat one together count as one.

    They repeat one error of rounding as well.

    Args:
        theta: (n, 2) measured angles [rad].
    """
    weight = np.ones(theta.shape)
    for of_encoder, reading in zip(weight.T, (theta @ READINGS.T).T, strict=True):
        runs = np.concatenate([[0], np.cumsum(np.abs(np.diff(reading)) > _REPEATED)])
        of_encoder[:] = 1.0 / np.bincount(runs)[runs]
    return weight


def _long_ones(time: Array, ends: Mask, longest: float) -> list[slice]:
    """Return the stretches of samples (n,) between ends (n - 1,) that last longer than some time [s]."""
    bounds = [0, *(np.flatnonzero(ends) + 1), len(time)]
    return [slice(a, b) for a, b in pairwise(bounds) if time[b - 1] - time[a] > longest]
