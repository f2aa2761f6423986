# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Even times of samples whose stamps are not: when each was measured, by how many came, and which of them were lost.

A USB converter hands over what came in 16 ms, a publisher what was read since the last time, a clock shows whole
milliseconds or is slewed. The device samples evenly all the same, and how many came tells when each was measured. Fast
motion tells where samples are missing. Where it is slow, bursts do: with one missing before, all later ones are late.
"""

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyvander
from scipy.ndimage import maximum_filter1d

from cdp_ident.arrays import Array, Indices
from cdp_ident.trial.kinematics import SAME, roughness

FEWEST = 30
"""Samples, below which nothing is said of their times."""
SMOOTHER = 0.5
"""Even times, or those of receipt, are taken where the motion is rougher by stamps than this allows."""
_ONCE, _AS_SMOOTH = 0.8, 1.2
"""The same, where fewer samples than this share have a stamp of their own."""
_NEAREST = 2.5
"""The fewest samples before and after one that tell smooth motion."""
UNEVEN, _EVEN = 0.03, 0.004
"""Times that are off even ones by less than this share of their spacing (rms) stay, rounded ones by the second."""
LONGEST_WAIT = 1.05
"""No buffer waits for longer, and no clock shows less than seconds [s]."""
_AT_REST = 0.1
"""Motion of less [rad or degrees] tells nothing of times."""
_FEW = 1.5
"""With no more samples each, there are no bursts but times that jitter."""
_REFITTED, _TYPICAL = 10, 2.5
"""Rounds of the fit of even times, and how far off burst may be in it, over the median."""
_NEXT, GAP = 0.6, 2.5
"""In usual distances of bursts, what is more is from one to the next, and beyond, nothing is known of the count."""
DIGITS, COARSEST = 1.25, 0.75
"""Rounded, even times lie within so many of their last digits about a line; and how many intervals a digit is at most.
"""
_LONG_PARTS, _PARTS, _ALIKE = 8, 32, 0.5
"""Errors of times go together over no more than one part in so many. A clock is slewed where the pace changes from one
part to the next by less than this share of its variance (von Neumann's ratio: 2 where it does so by chance)."""
_SLEWED = 2e-3
"""No clock is slewed by more, as a share."""
_EARLIEST, _FAST = 0.02, 0.9
"""No sample is stamped before it is measured but this share; so many are counted right, as at rest they may not be."""
_MISCOUNTED = 0.9
"""A count is wrong where the motion is smoother by another by this factor."""
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
_BESIDE = 12
"""Bursts before and after a loss that tell it."""
_SURE, _AGAINST = 20.0, 8.0
"""Twice the logarithm of the odds from which one more is lost, by motion and bursts; and how much of it bursts may say
against motion, as where they come after a whole number of samples all are late, or none."""
_NOTHING = 1e-12
_MOST, _AT_ONCE = 100, 4096


class Even(NamedTuple):
    """Even times of a stretch of samples."""

    time: Array
    step: float
    pace_std: float
    """Standard deviation of the step, as a share."""
    note: str


def evened(
    time: Array, angles: Array, parts: Indices, gap: float, digit: float = 0.0
) -> tuple[Array, list[str], float]:
    """Return times of samples (n,) [s], even where measured so, what there is to say, and how sure their pace is.

    They are stamped at `time` (n,), ascending [s], and show `angles` (n, k) [rad]; `parts` are the first samples after
    the clock was set back. Samples that were lost within bursts are found where the motion goes on as after a longer
    time. Beyond a `gap` of so many bursts nothing is known of the count. Times are rounded to a `digit`, if that is
    known. The last value is the standard deviation of the pace, as a share; 0 where times are as they were.
    """
    times, made = time.copy(), list[tuple[int, Even]]()
    digit = digit or last_digit(time)
    for part in np.split(np.arange(len(time)), parts):
        for stretch, wait in _stretches(part, time[part], gap):
            continuous = np.asarray(np.unwrap(angles[stretch], axis=0))
            moves = np.max(np.ptp(continuous, axis=0)) >= _AT_REST
            if moves and (even := _even_of(time[stretch], continuous, wait, digit)):
                times[stretch] = even.time
                made.append((len(stretch), even))
        # No time passes where a clock is set back.
        times[part] -= times[part[0]] - times[part[0] - 1] if len(part) and part[0] else 0.0
    if not made:
        return time, [], 0.0
    # A recording that is parted lets each of its parts say what it is.
    return times, list(dict.fromkeys(even.note for _, even in made)), max(made, key=lambda of: of[0])[1].pace_std


def last_digit(time: Array) -> float:
    """Return the last digit of rounded times (n,) [s], down to microseconds."""
    return 1e-6 * float(np.gcd.reduce(np.round(1e6 * time).astype(np.int64)))


def _even_of(time: Array, angles: Array, wait: float, digit: float) -> Even | None:
    """Return even times of samples that came every `wait` [s], stamped to such a digit; None where they are not."""
    steps = np.diff(time)
    usual = float(np.mean(steps[steps < 1.5 * max(float(np.median(steps)), wait / 2)])) or wait
    seen = np.append(0, np.cumsum(np.maximum(1, np.round(steps / usual)).astype(np.int64)))
    counts = [np.arange(len(time)), seen]
    line = np.linspace(time[0], time[-1], len(time))
    if np.std(time - line) > UNEVEN * (line[1] - line[0]):
        counts.append(_counted(angles, time, _ends(time, wait)))
    tried = [(even, index) for index in counts if (even := _even(index, time, wait))]
    if not tried:
        return None
    rough = [_rougher(even, time, angles, wait) for even, _ in tried]
    smooth = min(rough)[0] / _MISCOUNTED
    # Of counts by which the motion is smooth the right one is that by which samples come most evenly.
    spread = [float(np.std(time - times)) for (times, *_), _ in tried]
    best = min((of, k) for k, of in enumerate(spread) if rough[k][0] <= smooth)[1]
    (times, step, pace_std), index = tried[best]
    (found, most), off = rough[best], time - times
    if UNEVEN * usual < digit < COARSEST * usual and np.ptp(off) < DIGITS * digit:
        note = f"times are rounded to {1e3 * digit:.3g} ms: taken evenly, {1e3 * step:.4g} ms apart"
    elif np.std(off) <= UNEVEN * step:
        return None
    elif found < most:
        lost = int(index[-1]) + 1 - len(time)
        came = (
            f"samples came in bursts of about {wait / step:.2g} every {1e3 * wait:.3g} ms (a latency timer, a buffer?)"
        )
        came = "the times of samples jitter" if wait < _FEW * step else came
        missing = f"; {lost} are missing among them" if lost else ""
        note = f"{came}: they are taken {1e3 * step:.4g} ms apart, as the motion is smoother so{missing}"
    elif slewed := _slewed(off, step):
        pace_std = slewed
        note = (
            f"the clock of the stamps runs at a changing pace (slewed?): samples are taken evenly, {1e3 * step:.4g} ms "
            f"apart to {1e6 * pace_std:.2g} ppm"
        )
    else:
        return None
    return Even(times, step, pace_std, note)


def usual_wait(time: Array) -> float:
    """Return the time from one burst to the next [s], in which an instant drawn at random lies; 0 if none passes."""
    by_size = np.sort(np.minimum(np.diff(time), LONGEST_WAIT))
    return float(by_size[np.searchsorted(np.cumsum(by_size), by_size.sum() / 2)]) if len(by_size) else 0.0


def _stretches(part: Indices, time: Array, gap: float) -> Iterator[tuple[Indices, float]]:
    """Yield stretches of samples without a long gap, and the usual time from one burst of them to the next."""
    wait = usual_wait(time)
    if len(time) <= FEWEST or not wait:
        return
    for stretch in np.split(np.arange(len(time)), np.flatnonzero(np.diff(time) > gap * wait) + 1):
        if len(stretch) >= FEWEST and _even(np.arange(len(stretch)), time[stretch], wait, np.inf):
            yield part[stretch], wait


def _even(index: Indices, time: Array, wait: float, most: float = 1.0) -> tuple[Array, float, float] | None:
    """Return even times of samples of such a count, their step and how sure it is, as a share.

    None where those given are even, no buffer delays so, or there are too few bursts to tell.

    They go by the last samples of bursts, without those far off the others: where nothing moves, a count may be wrong.
    A sample waits for no longer than from one burst to the next, or `most` times that.
    """
    ends = _ends(time, wait)
    if len(ends) < _LONG_PARTS:
        return None
    kept = np.ones(len(ends), dtype=bool)
    for _ in range(_REFITTED):
        step, first = np.polyfit(index[ends][kept], time[ends][kept], 1)
        off = np.abs(time[ends] - first - step * index[ends])
        kept = off <= max(_TYPICAL * float(np.median(off)), 1e-9)
    late = time - step * index
    if np.std(late) <= _EVEN * step or np.quantile(np.abs(late - np.median(late)), _FAST) >= most * max(
        wait, _FEW * step
    ):
        return None
    # Errors go together for a while: by parts that are left out in turn (jackknife).
    part = np.arange(len(ends)) * _LONG_PARTS // len(ends)
    steps = [np.polyfit(index[ends][part != of], time[ends][part != of], 1)[0] for of in np.unique(part)]
    pace_std = float(np.sqrt((len(steps) - 1) * np.var(steps)) / step)
    return step * index + np.quantile(late[ends][kept], _EARLIEST), float(step), pace_std


def _slewed(off: Array, step: float) -> float:
    """Return by how much the pace of a clock varies (a standard deviation, as a share) that is slewed for a while.

    Its stamps of samples are `off` (n,) even times by so much [s]. 0 where these are not of such a clock.
    """
    if len(off) < _PARTS * NEAR:
        return 0.0
    paces = np.diff([np.mean(part) for part in np.array_split(off, _PARTS)]) * _PARTS / (step * len(off))
    is_alike = np.mean(np.diff(paces) ** 2) < _ALIKE * np.var(paces)
    return float(np.std(paces)) if is_alike and np.max(np.abs(paces)) < _SLEWED else 0.0


def _ends(time: Array, wait: float) -> Indices:
    """Return the last sample of each burst."""
    return np.flatnonzero(np.append(np.diff(time) > _NEXT * wait, True))


def _rougher(even: tuple[Array, float, float], time: Array, angles: Array, wait: float) -> tuple[float, float]:
    """Return the roughness of motion in even times, and up to which they are taken.

    The motion must be smoother than in the times of the stamps, each taken once. Where stamps are repeated, samples
    would be lost, and it need not be smoother, but as smooth.
    """
    times, *_ = even
    half_width = max(_BURSTS * wait, _NEAREST * float(times[-1] - times[0]) / len(times))
    once = np.concatenate([[True], np.diff(time) > 0])
    share = SMOOTHER if np.mean(once) > _ONCE else _AS_SMOOTH
    return roughness(times, angles, half_width), share * roughness(time[once], angles[once], half_width)


def _counted(angles: Array, time: Array, ends: Indices) -> Indices:
    """Return the count of samples with angles (n, k) [rad], from 0, with those between that were lost.

    They arrived at `time` (n,) [s] in bursts of which `ends` are the last.
    """
    index = np.arange(len(angles))
    places: Indices = np.arange(NEAR, len(angles) - NEAR + 1)
    left = off_cubics(index, angles, places)
    # An encoder at rest says the same again and again, whatever its noise in motion.
    changing = left[:, 0] > SAME
    usual = float(np.median(left[changing, 0])) if np.any(changing) else np.inf
    # Cubics leave so many of each joint's samples about a place free.
    free = angles.shape[1] * (2 * NEAR - 4)
    for _ in range(_MOST):
        least = left.min(axis=1)
        is_kink = (left[:, 0] > _KINK * usual) & (least < _STRAIGHT * left[:, 0])
        gain = is_kink * (left[:, 0] - least)
        best = np.flatnonzero(is_kink & (gain == maximum_filter1d(gain, 4 * NEAR)))
        if not len(best):
            break
        # The fewest that motion allows: bursts tell of more.
        allowed = free * (left[best] ** 2 - least[best, None] ** 2) < _AGAINST * usual**2
        np.add.at(lost := np.zeros(len(index), dtype=np.int64), places[best], _LOST[np.argmax(allowed, axis=1)])
        index += np.cumsum(lost)
        again = np.unique(np.clip(best[:, None] + np.arange(-NEAR, NEAR + 1), 0, len(places) - 1))
        left[again] = off_cubics(index, angles, places[again])
    after = np.searchsorted(ends, places)
    inside = (after > _BESIDE) & (after < len(ends) - _BESIDE)
    places, after, (none, one) = places[inside], after[inside], left[inside, :2].T
    by_motion = np.where(one < _KINK * usual, free * (none**2 - one**2) / usual**2, -np.inf)
    for _ in range(_MOST if len(places) else 0):
        count, late = index[ends] - np.mean(index[ends]), time[ends] - np.mean(time[ends])
        step = float(count @ late / (count @ count))
        rest = late - step * count
        # By least squares, how much later all are from each burst on: sums over the later bursts.
        of_count, of_late = (np.cumsum(values[::-1])[::-1][after] for values in (count, rest))
        more = len(ends) - after
        squares = more - more**2 / len(ends) - of_count**2 / (count @ count)
        by_bursts = step * (2.0 * of_late - step * squares) / max(float(np.mean(rest**2)), _NOTHING)
        odds = by_motion + np.maximum(by_bursts, -_AGAINST)
        place = places[most := int(np.argmax(odds))]
        if odds[most] <= _SURE:
            break
        index[place:] += 1
        by_motion[np.abs(places - place) < 2 * NEAR] = -np.inf
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
