# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Samples that came in bursts: when each was measured, by how many came, and which of them were lost.

A USB converter hands over what came in 16 ms, a driver what is in its buffer, and stamps then lie close together, with
nothing in between. The device samples evenly all the same, and how many came tells when each was measured. Fast motion
tells where samples are missing. Where it is slow, bursts do: with one missing before, all later ones are late.
"""

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.polynomial.polynomial import polyvander
from scipy.ndimage import maximum_filter1d

from cdp_ident.arrays import Array, Indices
from cdp_ident.trial.kinematics import roughness

FEWEST = 30
"""Samples, below which nothing is said of their times."""
SMOOTHER = 0.5
"""Even times, or those of receipt, are taken where the motion is rougher by stamps than this allows."""
_ONCE, _AS_SMOOTH = 0.8, 1.2
"""The same, where fewer samples than this share have a stamp of their own."""
_NEAREST = 2.5
"""The fewest samples before and after one that tell smooth motion."""
UNEVEN = 0.03
"""Times that are off even ones by less than this share of their spacing (rms) are taken as they are."""
LONGEST_WAIT = 1.05
"""No buffer waits for longer, and no clock shows less than seconds [s]."""
_AT_REST = 0.1
"""Motion of less [rad or degrees] tells nothing of times."""
_FEW = 1.5
"""With no more samples each, there are no bursts but times that jitter."""
_REFITTED, _TYPICAL = 10, 2.5
"""Rounds of the fit of even times, and how far off burst may be in it, over the median."""
_GAP = 2.5
"""Between bursts that are further apart than this, in usual distances, nothing is known of the count."""
_MISCOUNTED = 0.9
"""Samples are not lost where the motion is smoother without them by this factor."""
_BURSTS = 1.5
"""Bursts on either side that smooth motion is told by."""
NEAR = 4
"""Samples before and after a place that smooth motion is told by."""
Cases = tuple[tuple[int, int], ...]
_CASES: Cases = ((0, 0), *itertools.product(range(1, 5), range(NEAR)))
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


def evened(time: Array, angles: Array, parts: Indices) -> tuple[Array, list[str]]:
    """Return times of samples (n,) [s], evenly spaced where they came in bursts, and what there is to say about it.

    They are stamped at `time` (n,), ascending [s], and show `angles` (n, k) [rad]; `parts` are the first samples after
    the clock was set back. Samples that were lost within bursts are found where the motion goes on as after a longer
    time.
    """
    times, made = time.copy(), []
    for part in np.split(np.arange(len(time)), parts):
        for stretch, between in _bursts(part, time[part]):
            continuous = np.asarray(np.unwrap(angles[stretch], axis=0))
            if np.max(np.ptp(continuous, axis=0)) < _AT_REST:
                continue
            by_motion, slow = _by_motion(continuous)
            by_bursts = _by_bursts(by_motion, time[stretch], _ends(time[stretch], between), slow)
            counts = [by_bursts, np.arange(len(stretch))]
            evens = [_even(index, time[stretch], between) for index in counts]
            tried = [_rougher(even, time[stretch], continuous, between) for even in evens]
            is_whole = tried[1][0] < _MISCOUNTED * tried[0][0]
            last, even, (rough, most) = int(counts[is_whole][-1]), evens[is_whole], tried[is_whole]
            if even is not None and rough < most:
                times[stretch] = even
                made.append((len(stretch), between, float(np.ptp(even)) / last, last + 1 - len(stretch)))
    if not made:
        return time, []
    (_, wait, step, _), lost = max(made), sum(lacking for *_, lacking in made)
    came = f"samples came in bursts of about {wait / step:.2g} every {1e3 * wait:.3g} ms (a latency timer, a buffer?)"
    if wait < _FEW * step:
        came = "the times of samples jitter"
    missing = f"; {lost} are missing among them" if lost else ""
    return times, [f"{came}: they are taken {1e3 * step:.4g} ms apart, as the motion is smoother so{missing}"]


def _bursts(part: Indices, time: Array) -> Iterator[tuple[Indices, float]]:
    """Yield stretches of samples that may have come in bursts, without a long gap, and the usual time of a burst."""
    steps = np.diff(time)
    if len(steps) < FEWEST or not np.any(steps > 0):
        return
    # The step in which an instant drawn at random lies: that between bursts, not those within them.
    by_size = np.sort(np.minimum(steps, LONGEST_WAIT))
    wait = float(by_size[np.searchsorted(np.cumsum(by_size), by_size.sum() / 2)])
    for stretch in np.split(np.arange(len(time)), np.flatnonzero(steps > _GAP * wait) + 1):
        if len(stretch) >= FEWEST and _even(np.arange(len(stretch)), time[stretch], wait, np.inf) is not None:
            yield part[stretch], wait


def _even(index: Indices, time: Array, wait: float, most: float = 1.0) -> Array | None:
    """Return even times of samples of such a count; None where those given are even, or no buffer delays so.

    They go by the last samples of bursts, without those far off the others: where nothing moves, a count may be wrong.
    A sample waits for no longer than from one burst to the next, or `most` times that.
    """
    ends = _ends(time, wait)
    kept = np.ones(len(ends), dtype=bool)
    for _ in range(_REFITTED):
        step, first = np.polyfit(index[ends][kept], time[ends][kept], 1)
        off = np.abs(time[ends] - first - step * index[ends])
        kept = off <= max(_TYPICAL * float(np.median(off)), 1e-9)
    even = np.mean(time) + step * (index - np.mean(index))
    off = time - even
    is_late = np.max(np.abs(off)) < most * max(wait, _FEW * step)
    return np.asarray(even) if is_late and np.std(off) > UNEVEN * step else None


def _ends(time: Array, wait: float) -> Indices:
    """Return the last sample of each burst."""
    return np.flatnonzero(np.append(np.diff(time) > wait / 2, True))


def _rougher(even: Array | None, time: Array, angles: Array, wait: float) -> tuple[float, float]:
    """Return the roughness of motion in even times, and up to which they are taken; infinite where there are none.

    The motion must be smoother than in the times of the stamps, each taken once. Where stamps are repeated, samples
    would be lost, and it need not be smoother, but as smooth.
    """
    if even is None:
        return np.inf, 0.0
    half_width = max(_BURSTS * wait, _NEAREST * float(even[-1] - even[0]) / len(even))
    once = np.concatenate([[True], np.diff(time) > 0])
    share = SMOOTHER if np.mean(once) > _ONCE else _AS_SMOOTH
    return roughness(even, angles, half_width), share * roughness(time[once], angles[once], half_width)


def _by_motion(angles: Array) -> tuple[Indices, Indices]:
    """Return the count of samples with angles (n, k) [rad], from 0, with those between that were lost, as motion tells.

    The second value are the samples before which it tells nothing.
    """
    index = np.arange(len(angles))
    places = np.arange(NEAR, len(angles) - NEAR + 1)
    left = off_cubics(index, angles, places)
    # An encoder at rest says the same again and again, whatever its noise in motion.
    changing = left[:, 0] > _NOTHING
    usual = float(np.median(left[changing, 0])) if np.any(changing) else np.inf
    for _ in range(_MOST):
        least = left.min(axis=1)
        is_kink = (left[:, 0] > _KINK * usual) & (least < _STRAIGHT * left[:, 0])
        gain = is_kink * (left[:, 0] - least)
        best = np.flatnonzero(is_kink & (gain == maximum_filter1d(gain, 4 * NEAR)))
        if not len(best):
            break
        np.add.at(lost := np.zeros(len(index), dtype=np.int64), places[best], _LOST[np.argmin(left[best], axis=1)])
        index += np.cumsum(lost)
        again = np.unique(np.clip(best[:, None] + np.arange(-NEAR, NEAR + 1), 0, len(places) - 1))
        left[again] = off_cubics(index, angles, places[again])
    return index, places[left[:, 1] < _SLOW * np.maximum(left[:, 0], usual)]


def _by_bursts(index: Indices, time: Array, ends: Indices, slow: Indices) -> Indices:
    """Return the count of samples with those that were lost before some of the `slow` ones, as the bursts tell.

    They arrived at `time` (n,) [s]; `ends` are the last of each burst.
    """
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


def off_cubics(
    index: Array | Indices, angles: Array, places: Indices, cases: Cases = _CASES, near: int = NEAR
) -> Array:
    """Return how far angles (n, k) about places (m,) are from cubics over their count (n,), with each of some cases.

    Each place has so many samples `near` before it, and, with it, as many after.
    """
    around = np.arange(-near, near)
    skipped = np.array([lost * (around >= 0) + (another > 0) * (around >= another) for lost, another in cases])
    found = []
    for some in np.array_split(places, 1 + len(places) // _AT_ONCE):
        rows = some[:, None] + around
        counts, which = np.unique(index[rows] - index[some, None], axis=0, return_inverse=True)
        orthogonal, _ = np.linalg.qr(polyvander((counts[:, None] + skipped) / near, 3))
        off = np.eye(len(around)) - orthogonal @ np.swapaxes(orthogonal, -1, -2)
        found.append(np.linalg.norm(off[which.ravel()] @ angles[rows][:, None], axis=(2, 3)))
    return np.concatenate(found)
