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
from cdp_ident.trial.kinematics import CUBIC_AT_CENTRE, local_motion
from cdp_ident.trial.lost_samples import counted
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.order import elapsed, in_order

_FEWEST = 30
"""Samples, below which nothing is said of their times."""
_SMOOTHER = 0.5
"""Other times are taken where the motion is rougher by stamps than this allows."""
_ONCE, _AS_SMOOTH = 0.8, 1.2
"""The same for even times, where fewer samples than this share have a stamp of their own."""
_NEAR = 4
"""Samples before and after one that smooth motion is told by."""
_FAST, _LOOKED_AT = 0.9, 2000
"""It is looked at where it is fast, at this quantile: at rest, all times are as good; and at so many samples."""
_RATE = 0.02
"""Share by which durations by stamps and by receipt may differ, and beside it the rounding of stamps to seconds."""
_SECOND = 1_000_000_000
_UNEVEN = 0.2
"""Times that are off even ones by less than this share of their spacing (rms) are taken as they are."""
_LONGEST_WAIT = 0.25
"""No buffer waits for longer [s]."""
_REFITTED, _TYPICAL = 10, 2.5
"""Rounds of the fit of even times, and how far off burst may be in it, over the median."""
_GAP = 2.5
"""Between bursts that are further apart than this, in usual distances, nothing is known of the count."""
_BURSTS = 1.5
"""Bursts on either side that smooth motion is told by."""


def in_measured_time(recording: JointRecording, options: TrialOptions) -> JointRecording:
    """Return a recording whose stamps are the times of its samples, as `options.time` says, and what was done.

    By itself the time of receipt is taken only where stamps are missing, or the motion is far smoother by receipt.
    """
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
    if not lacking:
        return recording
    return replace(recording[stamped], notes=(*recording.notes, f"{lacking} messages without a stamp are dropped"))


def _fault(recording: JointRecording, options: TrialOptions) -> str:
    """Say what is wrong with stamps by which the motion is far rougher than by receipt; empty if nothing is."""
    stamps, receipts = recording.stamps, recording.receipts
    assert receipts is not None
    joints = [recording.joints.index(j) for j in (options.inner_joint, options.outer_joint) if j in recording.joints]
    by_stamp, by_receipt = (_rough(times, recording.positions[:, joints]) for times in (stamps, receipts))
    lasts = [elapsed(times)[-1] for times in (np.sort(stamps), receipts)]
    is_other = np.isfinite(by_stamp) and abs(lasts[0] - lasts[1]) > 1.0 + _RATE * lasts[1]
    if is_other or not by_receipt < _SMOOTHER * by_stamp:
        return ""
    largest = int(np.max(stamps % _SECOND))
    if largest == 0:
        return "are whole seconds"
    if largest < 1_000_000:
        return f"hold {'milli' if largest < 1000 else 'micro'}seconds where nanoseconds belong"
    return "are not the times of the samples, as the motion is smoother by receipt"


def _rough(stamps: Indices, readings: Array) -> float:
    """Return the roughness of joints' readings (n, k), each where it is known, with stamps in any order [ns]."""
    order, _ = in_order(stamps)
    found = []
    for column in readings[order].T:
        known = np.isfinite(column)
        if np.count_nonzero(known) < _FEWEST:
            return np.inf
        time, once = np.unique(elapsed(stamps[order][known]), return_index=True)
        found.append(roughness(time, column[known][once, None], _NEAR * float(time[-1]) / len(time)))
    return max(found, default=np.inf)


def evened(time: Array, angles: Array, parts: Indices) -> tuple[Array, list[str]]:
    """Return times of samples (n,) [s], evenly spaced where they came in bursts, and what there is to say about it.

    Samples that were lost within bursts are found where the motion goes on as after a longer time.

    Args:
        time: (n,) as stamped, ascending [s].
        angles: (n, k) measured then [rad].
        parts: where the clock was set back: the first sample after each such place.
    """
    times, longest, step, wait, lost = time.copy(), 0, 0.0, 0.0, 0
    for part in np.split(np.arange(len(time)), parts):
        for stretch, between in _bursts(part, time[part]):
            continuous = np.asarray(np.unwrap(angles[stretch], axis=0))
            index = counted(time[stretch], continuous, _ends(time[stretch], between))
            even = _even(index, time[stretch], between)
            if even is not None and _is_smoother(even, time[stretch], angles[stretch], between):
                times[stretch] = even
                lost += int(index[-1]) + 1 - len(index)
                if len(stretch) > longest:
                    longest, wait, step = len(stretch), between, float(np.ptp(even) / index[-1])
    if not longest:
        return time, []
    missing = f"; {lost} are missing among them" if lost else ""
    return times, [
        f"samples came in bursts of about {wait / step:.2g} every {1e3 * wait:.3g} ms (a latency timer, a buffer?): "
        f"they are taken {1e3 * step:.4g} ms apart, as the motion is smoother so{missing}"
    ]


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
    return np.asarray(even) if np.std(off) > _UNEVEN * step and np.max(np.abs(off)) < most * wait else None


def _ends(time: Array, wait: float) -> Indices:
    """Return the last sample of each burst."""
    return np.flatnonzero(np.append(np.diff(time) > wait / 2, True))


def _is_smoother(even: Array, time: Array, angles: Array, wait: float) -> bool:
    """Return whether the motion is smoother in even times than in those of the stamps, each taken once.

    Where stamps are repeated, samples would be lost, and it need not be smoother, but as smooth.
    """
    once = np.concatenate([[True], np.diff(time) > 0])
    share = _SMOOTHER if np.mean(once) > _ONCE else _AS_SMOOTH
    half_width = max(_BURSTS * wait, _NEAR * float(even[-1] - even[0]) / len(even))
    return roughness(even, angles, half_width) < share * roughness(time[once], angles[once], half_width)


def roughness(time: Array, angles: Array, half_width: float) -> float:
    """Return how far angles (n, k) are from cubics over twice the `half_width` [s] where that is much."""
    if len(time) < _FEWEST:
        return np.inf
    some = slice(None, None, max(1, len(time) // _LOOKED_AT))
    continuous = np.asarray(np.unwrap(angles, axis=0))
    smooth, _ = local_motion(time, continuous, time[some], half_width)
    together = max(6.0, 2.0 * half_width * len(time) / (time[-1] - time[0]))
    off = np.abs(continuous[some] - smooth) / np.sqrt(1.0 - CUBIC_AT_CENTRE / together)
    return float(np.max(np.quantile(off, _FAST, axis=0)))
