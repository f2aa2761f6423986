# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Samples that were lost among others that came in bursts, whose stamps tell little of when each was measured.

Fast motion tells where time is missing. Where it is slow, bursts do: with a sample missing before, all later ones are
late.
"""

import itertools

import numpy as np
from numpy.polynomial.polynomial import polyvander
from scipy.ndimage import maximum_filter1d

from cdp_ident.arrays import Array, Indices

_NEAR = 4
"""Samples before and after a place that smooth motion is told by."""
_CASES = ((0, 0), *itertools.product(range(1, 5), range(_NEAR)))
"""How many samples may be lost at a place, and after how many of those behind it one more is; 0: none."""
_LOST = np.array([lost for lost, _ in _CASES])
_KINK, _STRAIGHT = 2.5, 0.4
"""Some are lost where motion is so many times rougher than usual, and with them smoother by this factor."""
_SLOW = 5.0
"""One that would not make the motion so many times rougher may be lost unnoticed."""
_BESIDE = 12
"""Bursts before and after a loss that tell it."""
_LATE = 0.75
"""One is lost where all later bursts are late by more than this share of the time between samples."""
_NOTHING = 1e-9
_MOST, _AT_ONCE = 100, 4096


def counted(time: Array, angles: Array, ends: Indices) -> Indices:
    """Return the count of each of some samples (n,), from 0, with those between that were lost.

    Args:
        time: (n,) when they arrived [s].
        angles: (n, k) continuous [rad].
        ends: the last sample of each burst.
    """
    index, slow = _by_motion(angles)
    return _by_bursts(index, time, ends, slow)


def _by_motion(angles: Array) -> tuple[Indices, Indices]:
    """Return the count of samples as the motion tells, and the samples before which it tells nothing."""
    index = np.arange(len(angles))
    places = np.arange(_NEAR, len(angles) - _NEAR + 1)
    left = _off_cubics(index, angles, places)
    # An encoder at rest says the same again and again, whatever its noise in motion.
    changing = left[:, 0] > _NOTHING
    usual = float(np.median(left[changing, 0])) if np.any(changing) else np.inf
    for _ in range(_MOST):
        least = left.min(axis=1)
        is_kink = (left[:, 0] > _KINK * usual) & (least < _STRAIGHT * left[:, 0])
        gain = is_kink * (left[:, 0] - least)
        best = np.flatnonzero(is_kink & (gain == maximum_filter1d(gain, 4 * _NEAR)))
        if not len(best):
            break
        np.add.at(lost := np.zeros(len(index), dtype=np.int64), places[best], _LOST[np.argmin(left[best], axis=1)])
        index += np.cumsum(lost)
        again = np.unique(np.clip(best[:, None] + np.arange(-_NEAR, _NEAR + 1), 0, len(places) - 1))
        left[again] = _off_cubics(index, angles, places[again])
    return index, places[left[:, 1] < _SLOW * np.maximum(left[:, 0], usual)]


def _by_bursts(index: Indices, time: Array, ends: Indices, slow: Indices) -> Indices:
    """Return the count of samples with those that were lost before some of the `slow` ones, as the bursts tell."""
    after, first = np.unique(np.searchsorted(ends, slow), return_index=True)
    inside = (after > _BESIDE) & (after < len(ends) - _BESIDE)
    after, first = after[inside], first[inside]
    for _ in range(_MOST if len(after) else 0):
        count, late = index[ends] - np.mean(index[ends]), time[ends] - np.mean(time[ends])
        step = float(count @ late / (count @ count))
        # By least squares, how much later all are from each burst on: sums over the later bursts.
        of_count, of_late = (np.cumsum(values[::-1])[::-1][after] for values in (count, late - step * count))
        more = len(ends) - after
        squares = more - more**2 / len(ends) - of_count**2 / (count @ count)
        best = int(np.argmax(of_late**2 / squares * (of_late > _LATE * step * squares)))
        if of_late[best] <= _LATE * step * squares[best]:
            break
        index[slow[first[best]] :] += 1
    return index


def _off_cubics(index: Indices, angles: Array, places: Indices) -> Array:
    """Return how far angles (n, k) about places (m,) are from cubics over their count, with each of `_CASES`."""
    around = np.arange(-_NEAR, _NEAR)
    skipped = np.array([lost * (around >= 0) + (another > 0) * (around >= another) for lost, another in _CASES])
    found = []
    for some in np.array_split(places, 1 + len(places) // _AT_ONCE):
        rows = some[:, None] + around
        counts, which = np.unique(index[rows] - index[some, None], axis=0, return_inverse=True)
        orthogonal, _ = np.linalg.qr(polyvander((counts[:, None] + skipped) / _NEAR, 3))
        off = np.eye(len(around)) - orthogonal @ np.swapaxes(orthogonal, -1, -2)
        found.append(np.linalg.norm(off[which.ravel()] @ angles[rows][:, None], axis=(2, 3)))
    return np.concatenate(found)
