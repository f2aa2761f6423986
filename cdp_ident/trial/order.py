# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Samples in the order of their stamps, whatever order they are stored in."""

from bisect import bisect
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array, Indices, Mask
from cdp_ident.trial.kinematics import MEDIAN_OF_SIZE

_CLOCK_STEP = 10
"""So many samples in a row that go on from an earlier time mean that the clock was set back: stored in any order, one
in four million such rows ascends by chance."""
_NEAR = 3
"""Samples are neighbours up to so many times the usual spacing."""
_MOST_RUNS = 20_000
"""Beyond so many runs of samples, an order that says anything of the clock is no longer looked for."""

_AS_UNEVEN = 1 / 3
"""Steps of stamps that jitter vary by this share at least, put in order, of what they vary by as they are stored."""
_JITTER = 12.0
"""They are off the usual one by no more than so many times the median of that."""

_COUNTERS = {
    **{2.0**bits: f"a counter of {bits} bits" for bits in (8, 10, 12, 14, 16, 20, 24, 31, 32)},
    **{60.0: "seconds of a minute", 3600.0: "a time of an hour", 86400.0: "a time of day"},
}
"""What times begin anew after."""
_LIKE_OTHERS, _OFTEN = 10.0, 0.2
"""Within how many usual steps of one, or what share of a turn, they go on then; and how often of all steps at most."""


class _Run(NamedTuple):
    """Samples one after the other, without a gap between them: first and last stamp [ns], and which they are."""

    begin: int
    end: int
    first: int
    last: int

    @property
    def is_long(self) -> bool:
        return self.last - self.first >= _CLOCK_STEP


def in_order(stamps: Indices, known: Mask | None = None) -> tuple[Indices, list[str]]:
    """Return the samples that are used, in the order of time, and what there is to say about it.

    `stamps` (n,) [ns] are as they are stored. Samples that were stored late, whose stamps lie among those of others or
    fill a gap between them, are put there. Where samples go on from an earlier time instead, the clock was set back:
    they follow with stamps that are earlier. A few that are far from all others, and after which time goes on as
    before, are dropped. Messages of other joints, by `known` (n, 2), are no samples between: these may be stored at
    other times, as topic after topic.
    """
    everything = np.arange(len(stamps))
    if np.all(np.diff(stamps) >= 0):
        return everything, []
    joints = np.zeros(len(stamps)) if known is None else known @ [1, 2]
    alike = [np.flatnonzero(joints == of) for of in np.unique(joints)]
    found = [_parts(stamps, rows) for rows in alike]
    if len({len(parts) for parts, _ in found}) > 1:
        found = [_parts(stamps, everything)]
    together = [np.concatenate(parts) for parts in zip(*(parts for parts, _ in found), strict=True)]
    order = np.concatenate([part[np.argsort(stamps[part], kind="stable")] for part in together])
    late = sum(
        np.count_nonzero(stamps[part] < np.maximum.accumulate(stamps[part])) for parts, _ in found for part in parts
    )
    notes = [f"{late} samples that were stored late are put where their stamps belong"] if late else []
    if dropped := sum(dropped for _, dropped in found):
        notes.append(f"{dropped} samples with stamps far from those before and after them are dropped")
    return order, notes


def without_jitter(stamps: Indices, kinds: Array) -> tuple[Indices, str]:
    """Return stamps (n,) [ns] that do not step back by as little as they jitter, and in words that they did.

    Such samples were measured in the order in which they are stored: their stamps are put in order, and they are not.
    If they were stored in another order, stamps would be far more even in their own, or most would step back. `kinds`
    (n,) differ for messages of other joints.
    """
    ascending, stepping, sizes = stamps.copy(), 0, [0.0]
    for kind in np.unique(kinds):
        rows = np.flatnonzero(kinds == kind)
        steps = np.diff(stamps[rows])
        size, in_order = (
            float(np.median(np.abs(of - np.median(of)))) if len(of) else 0.0
            for of in (steps, np.diff(np.sort(stamps[rows])))
        )
        if in_order > _AS_UNEVEN * size and np.median(steps) > 0:
            far = np.abs(steps - np.median(steps)) > _JITTER * size
            part = np.append(0, np.cumsum(far))
            ascending[rows] = stamps[rows][np.lexsort((stamps[rows], part))]
            stepping += (back := np.count_nonzero((steps < 0) & ~far))
            sizes.append(size if back else 0.0)
    deviation = 1e-6 * max(sizes) / (MEDIAN_OF_SIZE * np.sqrt(2.0))
    note = f"{stepping} stamps step back within their jitter of {deviation:.2g} ms: samples stay as they are stored"
    return ascending, note if stepping else ""


def recorded_again(stamps: Indices, readings: Array) -> Mask:
    """Return which samples (n,) were there already, with the same stamp and readings, before others: of two recorders.

    Those that follow at once may be readings at rest, of a clock that is coarse.
    """
    again = np.zeros(len(stamps), dtype=bool)
    if np.all(np.diff(stamps) >= 0):
        return again
    begins = np.diff(stamps, prepend=stamps[:1] - 1) != 0
    values, counts = np.unique(stamps[begins], return_counts=True)
    some = np.flatnonzero(np.isin(stamps, values[counts > 1]))
    rows = np.column_stack([stamps[some], readings[some].view(np.int64)])
    _, first, which = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    others = np.cumsum(begins)[some]
    again[some] = others != others[first[which.ravel()]]
    return again


def _parts(stamps: Indices, rows: Indices) -> tuple[list[Indices], int]:
    """Return the parts of some rows between which the clock was set back, each as stored, and how many are dropped."""
    stamps = stamps[rows]
    steps = np.diff(stamps)
    near = _NEAR * int(np.median(np.abs(steps))) if len(steps) else 0
    cuts = [0, *(np.flatnonzero((steps < 0) | (steps > near)) + 1).tolist(), len(stamps)]
    if len(cuts) > _MOST_RUNS:
        return [rows], 0
    runs = [_Run(int(stamps[a]), int(stamps[b - 1]), a, b) for a, b in pairwise(cuts)]
    parts: list[list[_Run]] = [[]]
    dropped = 0
    for number, run in enumerate(runs):
        latest = parts[-1][-1].end if parts[-1] else run.begin
        place = bisect(parts[-1], run)
        if run.begin >= latest:
            parts[-1].append(run)
        elif _meet([run], parts[-1][max(0, place - 1) : place + 1], near):
            before = parts[-1][place - 1]
            if place and run.begin < before.end:
                # Parted where another lies in it, so that the neighbours of the next ones are those beside them.
                at = before.first + int(np.searchsorted(stamps[before.first : before.last], run.begin, side="right"))
                parts[-1][place - 1] = before._replace(end=int(stamps[at - 1]), last=at)
                parts[-1].insert(place, before._replace(begin=int(stamps[at]), first=at))
            parts[-1].insert(place, run)
        elif not run.is_long and (number + 1 == len(runs) or runs[number + 1].begin >= latest):
            dropped += run.last - run.first
        else:
            parts.append([run])
    stored = (sorted(part, key=lambda run: run.first) for part in _put_together(parts, near))
    return [rows[np.concatenate([np.arange(run.first, run.last) for run in part])] for part in stored], dropped


def elapsed(stamps: Indices) -> Array:
    """Return how long after the first of some stamps each of them was [s], as if no clock had been set back."""
    set_back = np.concatenate([[0], np.minimum(np.diff(stamps), 0)])
    # Differences of the integers first: a float of seconds since 1970 does not resolve nanoseconds.
    return np.asarray(stamps - stamps[0] - np.cumsum(set_back), dtype=float) * 1e-9


def counted_on(time: Array) -> tuple[Array, str]:
    """Return times (n,) in any unit, counted on where a counter of them rolls over, and which one that is, in words.

    What is left of a step back and a whole turn is a step like others then, and there are no times beyond a turn.
    """
    known = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[known])
    forth, back = steps[steps > 0.0], steps[steps < 0.0]
    if not 0 < len(back) < _OFTEN * len(forth):
        return time, ""
    usual, whole = float(np.median(forth)), float(max(np.ptp(time[known]), np.max(np.abs(time[known]))))
    turns = [(10.0 ** (3 * m) * turn, what) for m in range(-3, 5) for turn, what in _COUNTERS.items()]
    possible = [(float(np.max(np.abs(back + turn - usual))), turn, what) for turn, what in turns if turn >= whole]
    off, turn, what = min(possible, default=(np.inf, 0.0, ""))
    if off > min(_LIKE_OTHERS * usual, _OFTEN * turn):
        return time, ""
    counted = time.copy()
    counted[known[1:]] += turn * np.cumsum(steps < 0.0)
    return counted, what


def _put_together(parts: list[list[_Run]], near: int) -> list[list[_Run]]:
    """Return parts of which none goes on from another, or leads to it, as blocks do that are stored in no order."""
    whole: list[list[_Run]] = []
    for part in parts:
        rest = part
        for other in [*whole]:
            if _meet(rest, other, near):
                whole.remove(other)
                rest = sorted([*other, *rest])
        whole.append(rest)
    return sorted(whole, key=lambda part: min(run.first for run in part))


def _meet(runs: list[_Run], others: list[_Run], near: int) -> bool:
    """Return whether some runs go on from others, or lead to them, and the samples of no two are of the same time."""
    pairs = list(pairwise(sorted([*runs, *others])))
    crosses = any(after.begin < before.end and before.is_long and after.is_long for before, after in pairs)
    near_by = [(before, after) for before, after in pairs if after.begin - before.end <= near]
    return not crosses and any((before in others) != (after in others) for before, after in near_by)
