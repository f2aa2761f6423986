# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When samples were measured: by their stamps, by the times of receipt or by their count, as the motion tells.

A stamp may hold milliseconds where nanoseconds belong; a USB converter hands over what came in 16 ms, a driver what is
in its buffer, and stamps then lie close together, with nothing in between. The device samples evenly all the same, and
how many came tells when each was measured. Of all these times, the motion is smoothest in its own.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.trial.kinematics import off_smooth
from cdp_ident.trial.lost_samples import counted
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.order import counted_on, elapsed, in_order

_FEWEST = 30
"""Samples, below which nothing is said of their times."""
_SMOOTHER = 0.5
"""Other times are taken where the motion is rougher by stamps than this allows."""
_ONCE, _AS_SMOOTH = 0.8, 1.2
"""The same for even times, where fewer samples than this share have a stamp of their own."""
_NEAR, _NEAREST = 4, 2.5
"""Samples before and after one that smooth motion is told by, and the fewest that tell it."""
_FAST = 0.9
"""It is looked at where it is fast, at this quantile: at rest, all times are as good."""
_RATE = 0.02
"""Share by which durations by stamps and by receipt may differ, and beside it the rounding of stamps to seconds."""
_OTHER_PACE = 0.05
"""Share from which it is said."""
_SECOND = 1_000_000_000
_SHORTEST_STEP, _LONGEST_STEP = 1e-5, 0.5
"""Samples that are nearer or farther apart [s] show no swing."""
_UNEVEN = 0.03
"""Times that are off even ones by less than this share of their spacing (rms) are taken as they are."""
_LONGEST_WAIT = 1.05
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


def in_measured_time(recording: JointRecording, options: TrialOptions) -> JointRecording:
    """Return a recording whose stamps are the times of its samples, as `options.time` says, and what was done.

    By itself the time of receipt is taken only where stamps are missing, or the motion is far smoother by receipt.
    """
    times, counter = counted_on(recording.stamps.astype(float))
    if counter:
        note = f"the stamps are {counter}: they are counted on where it rolls over"
        recording = replace(recording, stamps=times.astype(np.int64), notes=(*recording.notes, note))
    stamps, receipts = recording.stamps, recording.receipts
    if receipts is None or not len(stamps):
        return recording
    stamped = np.flatnonzero(stamps > 0)
    lacking = len(stamps) - len(stamped)
    fault = "are missing" if 2 * lacking > len(stamps) else _fault(recording[stamped], options)
    if options.time == "receipt" or (options.time == "auto" and fault):
        why = f"the stamps {fault}: " if fault else ""
        notes = (*recording.notes, f"{why}the time of receipt is used, with its jitter")
        return replace(recording, stamps=receipts, device=None, notes=notes)
    said = [
        f"{lacking} messages without a stamp are dropped" if lacking else "",
        _pace(stamps[stamped], receipts[stamped]),
    ]
    return replace(recording[stamped] if lacking else recording, notes=(*recording.notes, *filter(None, said)))


def _fault(recording: JointRecording, options: TrialOptions) -> str:
    """Say what is wrong with stamps by which the motion is far rougher than by receipt; empty if nothing is."""
    stamps, receipts = recording.stamps, recording.receipts
    assert receipts is not None
    if len(stamps) < _FEWEST:
        return ""
    steps, received = (1e-9 * np.diff(np.sort(times)) for times in (stamps, receipts))
    too = "long" if np.median(steps) > _LONGEST_STEP else "short" if 0.0 < np.mean(steps) < _SHORTEST_STEP else ""
    if too and _SHORTEST_STEP <= np.mean(received) <= _LONGEST_STEP:
        return f"are {np.mean(steps):.3g} s apart, which is too {too} for a swing"
    if np.mean(received) < _SHORTEST_STEP:  # written at once, by a converter
        return ""
    joints = [recording.joints.index(j) for j in (options.inner_joint, options.outer_joint) if j in recording.joints]
    by_stamp, by_receipt = (_columns(times, recording.positions[:, joints]) for times in (stamps, receipts))
    of_both = (*by_stamp, *by_receipt)
    spacing = max((float(np.mean(np.diff(time))) for time, _ in of_both if len(time) > 1), default=0.0)
    rough = [
        max((roughness(*of, _NEAR * spacing) for of in columns), default=np.inf) for columns in (by_stamp, by_receipt)
    ]
    lasts = [elapsed(times)[-1] for times in (np.sort(stamps), receipts)]
    is_other = np.isfinite(rough[0]) and abs(lasts[0] - lasts[1]) > 1.0 + _RATE * lasts[1]
    if is_other or not rough[1] < _SMOOTHER * rough[0]:
        return ""
    largest = int(np.max(stamps % _SECOND))
    if largest == 0:
        return "are whole seconds"
    if largest < 1_000_000:
        return f"hold {'milli' if largest < 1000 else 'micro'}seconds where nanoseconds belong"
    return "are not the times of the samples, as the motion is smoother by receipt"


def _columns(stamps: Indices, readings: Array) -> list[tuple[Array, Array]]:
    """Return times (m,) and values (m, 1) of joints' readings (n, k) with stamps in any order [ns]; gaps are closed."""
    order, _ = in_order(stamps)
    time, found = elapsed(stamps[order]), []
    time = np.cumsum(np.minimum(np.diff(time, prepend=time[:1]), _LONGEST_WAIT))
    for column in readings[order].T:
        known = np.isfinite(column)
        once, first = np.unique(time[known], return_index=True)
        found.append((once, column[known][first, None]))
    return found


def _pace(stamps: Indices, receipts: Indices) -> str:
    """Say that samples come evenly in another time by their stamps than by receipt; empty if they do not."""
    if len(stamps) < _FEWEST:
        return ""
    steps = [1e-9 * np.diff(times) for times in (stamps, receipts)]
    usual, whole = ([float(of(step)) for step in steps] for of in (np.median, np.sum))
    if min(*usual, *whole) < _SHORTEST_STEP or max(usual) < (1.0 + _OTHER_PACE) * min(usual):
        return ""
    is_even = abs(usual[0] / usual[1] * whole[1] / whole[0] - 1.0) < _OTHER_PACE
    by = " but ".join(f"{1e3 * step:.3g} ms by {how}" for step, how in zip(usual, ("stamps", "receipt"), strict=True))
    return f"samples are {by} apart (played back at another rate?): time: receipt takes the latter" if is_even else ""


def evened(time: Array, angles: Array, parts: Indices) -> tuple[Array, list[str]]:
    """Return times of samples (n,) [s], evenly spaced where they came in bursts, and what there is to say about it.

    Samples that were lost within bursts are found where the motion goes on as after a longer time.

    Args:
        time: (n,) as stamped, ascending [s].
        angles: (n, k) measured then [rad].
        parts: where the clock was set back: the first sample after each such place.
    """
    times, made = time.copy(), []
    for part in np.split(np.arange(len(time)), parts):
        for stretch, between in _bursts(part, time[part]):
            continuous = np.asarray(np.unwrap(angles[stretch], axis=0))
            if np.max(np.ptp(continuous, axis=0)) < _AT_REST:
                continue
            counts = [counted(time[stretch], continuous, _ends(time[stretch], between)), np.arange(len(stretch))]
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
    if len(steps) < _FEWEST or not np.any(steps > 0):
        return
    # The step in which an instant drawn at random lies: that between bursts, not those within them.
    by_size = np.sort(np.minimum(steps, _LONGEST_WAIT))
    wait = float(by_size[np.searchsorted(np.cumsum(by_size), by_size.sum() / 2)])
    for stretch in np.split(np.arange(len(time)), np.flatnonzero(steps > _GAP * wait) + 1):
        if len(stretch) >= _FEWEST and _even(np.arange(len(stretch)), time[stretch], wait, np.inf) is not None:
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
    return np.asarray(even) if is_late and np.std(off) > _UNEVEN * step else None


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
    share = _SMOOTHER if np.mean(once) > _ONCE else _AS_SMOOTH
    return roughness(even, angles, half_width), share * roughness(time[once], angles[once], half_width)


def roughness(time: Array, angles: Array, half_width: float) -> float:
    """Return how far angles (n, k) are from cubics over twice the `half_width` [s] where that is much."""
    if len(time) < _FEWEST:
        return np.inf
    off = off_smooth(time, np.asarray(np.unwrap(angles, axis=0)), half_width)
    return float(np.max(np.quantile(off, _FAST, axis=0)))
