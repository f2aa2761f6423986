# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Joints that are measured at times of their own, at common times."""

import numpy as np
from scipy.interpolate import CubicSpline

from cdp_ident.arrays import Array, Indices, Mask
from cdp_ident.trial.outliers import TURN, outliers

_TOGETHER = 0.9
"""Share of the readings of a joint that have one of the other beside them, up to which joints are measured together."""
_BRIDGED = 3.5
"""No reading is made up in a gap of so many usual spacings."""


def at_common_times(time: Array, readings: Array, known: Mask) -> tuple[Indices, Array, str]:
    """Return the rows in which both joints have a reading, their readings (m, 2), and in words how they have one.

    Where most rows lack one joint, the readings of the joint that is measured more often are taken at the times of the
    other, by a cubic spline.

    Args:
        time: (n,) of the rows, ascending [s].
        readings: (n, 2) of the inner and outer joint.
        known: (n, 2) which are readings.
    """
    both = np.flatnonzero(known.all(axis=1))
    counts = np.count_nonzero(known, axis=0)
    if len(both) >= _TOGETHER * counts.min():
        return both, readings[both], ""
    slow = int(np.argmin(counts))
    rows = np.flatnonzero(known[:, slow])
    of_other = np.flatnonzero(known[:, 1 - slow])
    times, first = np.unique(time[of_other], return_index=True)
    values = np.asarray(np.unwrap(readings[of_other[first], 1 - slow]))
    good = ~outliers(times, values, TURN)
    there, between = _between(times[good], values[good], time[rows])
    found = readings[rows[there]]
    found[:, 1 - slow] = between[there]
    joint = ("inner", "outer")[1 - slow]
    apart = f"joints are measured at times of their own: the {joint} one is taken at the times of the other"
    lost = np.count_nonzero(~there)
    return rows[there], found, f"{apart}; {lost} samples without it nearby are dropped" if lost else apart


def _between(times: Array, values: Array, at: Array) -> tuple[Mask, Array]:
    """Return at which of some times there are values nearby, and the values there (those elsewhere mean nothing)."""
    if len(times) < 4:
        return np.zeros(len(at), dtype=bool), np.zeros(len(at))
    place = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    before, after = times[place], times[place + 1]
    step = np.median(np.diff(times))
    bridged = (at >= before) & (at <= after) & (after - before <= _BRIDGED * step)
    there = bridged | (np.minimum(np.abs(at - before), np.abs(at - after)) <= step / 2)
    return there, np.asarray(CubicSpline(times, values)(at))
