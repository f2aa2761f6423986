# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Samples that are no measurements: spikes of an encoder or of a damaged recording, up to three in a row.

The smallest set of samples is looked for without which the motion around it is smooth while each of the set is far from
that motion: by the deleted residual from a local cubic, studentized by what the neighbours scatter about it (Belsley,
Kuh and Welsch, Regression Diagnostics, 1980), or by the noise thereabouts where that is more. So nothing of the
mechanism's motion is one, however large it is relative to the noise: about an impulse (a kink), lost counts (a step
that stays), a joint that stops or sticks, and a motion too fast for its sampling, the neighbours scatter as well, and
no set's residuals reach 4.

A step that stays is looked for in the same way: beside it, the neighbours on both sides are smooth together.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.polynomial.polynomial import polyvander
from scipy.ndimage import maximum_filter1d

from cdp_ident.arrays import Array, Indices, Mask
from cdp_ident.trial.kinematics import MEDIAN_OF_SIZE, SAMPLES, encoder_step, fourth_differences

TURN = 2.0 * np.pi
"""What an angle is known up to [rad]."""
_LIMIT = 8.0
"""Studentized residual beyond which a sample is an outlier."""
_BESIDE = 5
"""Samples on either side that the cubic is fitted to; as near to one another, outliers are to be found together."""
_TOGETHER = 3
"""So many at most are found together."""
_SETS = [
    np.cumsum((0, *gaps))
    for others in range(_TOGETHER)
    for gaps in itertools.product(range(1, _BESIDE + 1), repeat=others)
]
"""Places of samples that may be outliers together, counted from the first of them; small sets first."""
_NEAR = 2 * _BESIDE + int(_SETS[-1][-1])
"""Samples no further apart are in one cubic's set and neighbours."""
_SUSPECT = 5.0
"""Outliers are looked for where a fourth difference is so many times the noise."""
_BLOCK = 64
"""The noise is that of so many samples, or of their neighbours where it is more: it may change with the motion."""
_FINEST = 5e-5
"""Noise counts for no less [rad or m]: a fine encoder that is read unevenly errs by a count now and then."""
_AT_ONCE = 1 << 12
"""Places at which all is computed at once: more take more memory and no less time."""
_RIDGE = 1e-12
"""Added to the normal equations over times from -1 to 1, which are singular where all but a few samples coincide."""
_NEIGHBOURS = 5.5
"""Samples further apart than so many usual spacings are no neighbours."""


def outliers(time: Array, values: Array, period: float | None = None) -> Mask:
    """Return which samples are outliers (n,).

    `time` (n,) [s] increases except where the clock was set back; `values` (n,) [rad or m] are known up to a `period`,
    as `TURN` for angles.
    """
    found = np.zeros(len(time), dtype=bool)
    look: Mask = np.ones(len(time), dtype=bool)
    spacing = np.diff(time)
    apart = (spacing <= 0.0) | (spacing > _NEIGHBOURS * np.median(spacing)) if len(spacing) else spacing > 0.0
    part = np.concatenate([[0], np.cumsum(apart)])[: len(time)]
    while np.any(look):
        kept = np.flatnonzero(~found)
        dropped = np.zeros(len(time), dtype=bool)
        dropped[kept[_among_neighbours(time[kept], values[kept], period, part[kept], look[kept])]] = True
        found |= dropped
        # Where some were found, there may be more without them: those that they hid, or their noise did.
        look = np.asarray(maximum_filter1d(dropped, 4 * _BLOCK + 1))
    return found


def outlier_words(times: Sequence[float], samples: int) -> str:
    """Say how many outliers there are beside so many samples that are none, and where: `times` [s], ascending."""
    count = len(times)
    words = "1 outlier (" if count == 1 else f"{count} outliers ("
    first = f"at {times[0]:.3f} s" if count == 1 else f"the first at {times[0]:.3f} s"
    return f"{words}{100 * count / (count + samples):.2g} %) {'is' if count == 1 else 'are'} left out, {first}"


def steps(time: Array, values: Array) -> Array:
    """Return by how much each of some continuous values (n,) at times (n,) [s] steps away from the motion before it.

    It is zero but where counts are lost: there a step beside the cubic through the neighbours on both sides leaves next
    to nothing of them, as beside a kink it does not.
    """
    sizes, studentized, size = np.zeros(len(time)), np.zeros(len(time)), 2 * _BESIDE
    if len(time) < size + SAMPLES:
        return sizes
    noise, suspect = _noise(time, values, None)
    places = np.flatnonzero(suspect[_BESIDE : len(time) - _BESIDE]) + _BESIDE
    for at in _few(places):
        index = at[:, None] + np.arange(-_BESIDE, _BESIDE)
        begin, end = time[index[:, :1]], time[index[:, -1:]]
        is_after = np.broadcast_to(np.arange(size) >= _BESIDE, index.shape)
        basis = np.concatenate(
            [polyvander((2.0 * time[index] - begin - end) / (end - begin), 3), is_after[..., None]], 2
        )
        transposed = basis.transpose(0, 2, 1)
        covariance = np.linalg.inv(transposed @ basis + _RIDGE * np.eye(5))
        factors = covariance @ transposed @ values[index][..., None]
        left = values[index] - (basis @ factors)[..., 0]
        scatter = np.sqrt(np.sum(left**2, axis=1) / (size - 5))
        sizes[at] = factors[:, 4, 0]
        studentized[at] = np.abs(sizes[at]) / (np.maximum(scatter, noise[at]) * np.sqrt(covariance[:, 4, 4]))
    is_step = (studentized > _LIMIT) & (studentized == maximum_filter1d(studentized, 2 * size + 1))
    return np.where(is_step, sizes, 0.0)


def _few(places: Indices) -> list[Indices]:
    """Part places into so few at once that what is computed of each takes little memory."""
    return np.array_split(places, 1 + len(places) // _AT_ONCE)


def _among_neighbours(time: Array, values: Array, period: float | None, part: Indices, look: Mask) -> Mask:
    """Return which are outliers (n,), looked for in some places, of samples of which those in one part have no gaps."""
    first = np.searchsorted(part, part)
    end = np.searchsorted(part, part, side="right")
    noise, suspect = np.zeros(len(time)), np.zeros(len(time), dtype=bool)
    for begin in np.unique(first).tolist():
        there = slice(begin, int(end[begin]))
        if end[begin] - begin > 2 * _BESIDE + SAMPLES and np.any(look[there]):
            noise[there], suspect[there] = _noise(time[there], values[there], period)
    suspect &= look
    dropped = np.zeros(len(time), dtype=bool)
    for places in _SETS:
        starts = np.flatnonzero(suspect & (end - first > 2 * _BESIDE + places[-1]))
        starts = starts[starts + places[-1] < end[starts]]
        least = np.concatenate(
            [_least_residuals(time, values, period, noise, of, places, first[of], end[of]) for of in _few(starts)]
        )
        if np.any(least > _LIMIT):
            residuals = np.zeros(len(time))
            residuals[starts] = least
            greatest = maximum_filter1d(residuals, 2 * _NEAR + 1)
            outlying = np.flatnonzero((residuals > _LIMIT) & (residuals == greatest))
            dropped[outlying[:, None] + places] = True
            suspect &= ~maximum_filter1d(dropped, 2 * _NEAR + 1)
    return dropped


def _noise(time: Array, values: Array, period: float | None) -> tuple[Array, Mask]:
    """Return the standard deviation of the noise about each of some samples (n,), and which may be outliers (n,)."""
    unwrapped = np.asarray(np.unwrap(values, period=period) if period else values)
    differences = np.abs(fourth_differences(time, unwrapped))
    blocks = np.array_split(differences, max(1, len(differences) // _BLOCK))
    of_blocks = maximum_filter1d([np.median(block) / MEDIAN_OF_SIZE for block in blocks], 3)
    noise = np.pad(np.repeat(of_blocks, [len(block) for block in blocks]), SAMPLES // 2, mode="edge")
    noise = np.maximum(np.maximum(noise, _FINEST), encoder_step(unwrapped) / np.sqrt(12.0))
    # Each by the worst difference it is in; those at the ends are in few, and always suspect.
    worst = maximum_filter1d(np.pad(differences, SAMPLES // 2, constant_values=np.inf), SAMPLES)
    return noise, np.asarray(worst > _SUSPECT * noise)


def _least_residuals(
    time: Array,
    values: Array,
    period: float | None,
    noise: Array,
    starts: Indices,
    places: Indices,
    begins: Indices,
    ends: Indices,
) -> Array:
    """Return the least studentized residual (m,) of the samples at `places` (p,) from each of the starts (m,).

    Neighbours are those of its part, whose first sample and end are given (m,).
    """
    size = 2 * _BESIDE + int(places[-1]) + 1
    first = np.clip(starts - _BESIDE, begins, ends - size)
    index = first[:, None] + np.arange(size)
    members = starts[:, None] + places
    is_member = (index[:, :, None] == members[:, None, :]).any(axis=2)
    others = index[~is_member].reshape(len(starts), size - len(places))
    measured, turns = values[others], np.zeros(others.shape)
    if period:
        turns[:, 1:] = np.cumsum(np.round(np.diff(measured, axis=1) / period), axis=1)
        measured -= period * turns
    begin, end = time[first][:, None], time[first + size - 1][:, None]
    basis, at_members = (polyvander((2.0 * time[at] - begin - end) / (end - begin), 3) for at in (others, members))
    transposed = basis.transpose(0, 2, 1)
    fit = np.linalg.solve(transposed @ basis + _RIDGE * np.eye(4), transposed)
    left = measured - (basis @ fit @ measured[..., None])[..., 0]
    scatter = np.sqrt(np.sum(left**2, axis=1) / (others.shape[1] - 4))
    weights = at_members @ fit
    off = values[members] - (weights @ measured[..., None])[..., 0]
    if period:
        off -= period * np.round(off / period)
    deviation = np.maximum(scatter, noise[starts])[:, None] * np.sqrt(1.0 + np.sum(weights**2, axis=2))
    # Before the first and after the last of the others the motion may change: more than it moves by is asked there.
    beyond = (members < others[:, :1]) | (members > others[:, -1:])
    moves = np.max(np.abs(np.diff(measured, axis=1)), axis=1)[:, None]
    return np.asarray(np.min(np.abs(off) / np.maximum(deviation, beyond * moves / _LIMIT), axis=1))
