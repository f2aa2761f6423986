"""Evenly spaced times for samples that arrive in bursts and are stamped as they arrive.

A USB converter hands over what came in 16 ms, a driver what is in its buffer: stamps then lie close together, with
nothing in between. The device samples evenly all the same, and how many came tells when each was measured. Whether it
is so, the motion decides: it is smoother in its true times.
"""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from cdp_ident.trial.kinematics import cubic_basis

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_FEWEST = 30
_UNEVEN = 0.2
"""Times that are off even ones by less than this share of their spacing (rms) are taken as they are."""
_LONGEST_WAIT = 0.25
"""No buffer waits for longer [s]."""
_GAP = 2.5
"""Between bursts that are further apart than this, in usual distances, samples are missing."""
_BURSTS = 3
"""So many bursts are compared with a cubic, ..."""
_LEAST_BLOCK = 8
"""... and at least so many samples."""
_SMOOTHER = 0.5
"""Even times are taken where the motion is rougher by stamps than this allows."""
_ONCE, _AS_SMOOTH = 0.8, 1.2
"""The same where fewer samples than this share have a stamp of their own."""
_FAST = 0.9
"""It is looked at where it is fast, at this quantile: at rest, all times are as good."""


def evened(time: Array, angles: Array, parts: Indices) -> tuple[Array, list[str]]:
    """Return times of samples (n,) [s], evenly spaced where they came in bursts, and what there is to say about it.

    Args:
        time: (n,) as stamped, ascending [s].
        angles: (n, k) measured then [rad].
        parts: where the clock was set back: the first sample after each such place.
    """
    times, longest, step, wait = time.copy(), 0, 0.0, 0.0
    for part in np.split(np.arange(len(time)), parts):
        for stretch, even, between in _even_stretches(part, time[part]):
            if _is_smoother(even, time[stretch], angles[stretch], between):
                times[stretch] = even
                if len(stretch) > longest:
                    longest, step, wait = len(stretch), float(even[1] - even[0]), between
    if not longest:
        return time, []
    return times, [
        f"samples came in bursts of about {wait / step:.2g} every {1e3 * wait:.3g} ms (a latency timer, a buffer?): "
        f"they are taken {1e3 * step:.4g} ms apart, as the motion is smoother so"
    ]


def _even_stretches(part: Indices, time: Array) -> Iterator[tuple[Indices, Array, float]]:
    """Yield stretches in which no sample is missing and times are uneven, even times, and the usual time of a burst."""
    steps = np.diff(time)
    if len(steps) < _FEWEST or not np.any(steps > 0):
        return
    # The step in which an instant drawn at random lies: that between bursts, not those within them.
    by_size = np.sort(np.minimum(steps, _LONGEST_WAIT))
    wait = float(by_size[np.searchsorted(np.cumsum(by_size), by_size.sum() / 2)])
    for stretch in np.split(np.arange(len(time)), np.flatnonzero(steps > _GAP * wait) + 1):
        if len(stretch) < _FEWEST:
            continue
        index = stretch - np.mean(stretch)
        step = float(index @ time[stretch] / (index @ index))
        even = np.mean(time[stretch]) + step * index
        off = time[stretch] - even
        # A sample waits for no longer than from one burst to the next.
        if np.std(off) > _UNEVEN * step and np.max(np.abs(off)) < wait:
            yield part[stretch], even, wait


def _is_smoother(even: Array, time: Array, angles: Array, wait: float) -> bool:
    """Return whether the motion is smoother in even times than in those of the stamps, each taken once.

    Where stamps are repeated, samples would be lost, and it need not be smoother, but as smooth.
    """
    once = np.concatenate([[True], np.diff(time) > 0])
    share = _SMOOTHER if np.mean(once) > _ONCE else _AS_SMOOTH
    return _roughness(even, angles, _BURSTS * wait) < share * _roughness(time[once], angles[once], _BURSTS * wait)


def _roughness(time: Array, angles: Array, lasts: float) -> float:
    """Return how far angles (n, k) are from cubics over so long a time each [rad rms], where that is much."""
    size = max(_LEAST_BLOCK, round(lasts * len(time) / (time[-1] - time[0])))
    blocks = len(time) // size
    if not blocks:
        return np.inf
    times = time[: blocks * size].reshape(blocks, size)
    values = np.unwrap(angles, axis=0)[: blocks * size].reshape(blocks, size, -1)
    ends = times[:, [0, -1]]
    basis = cubic_basis((2.0 * times - ends.sum(axis=1, keepdims=True)) / np.diff(ends, axis=1))
    orthogonal, _ = np.linalg.qr(basis)
    left = values - orthogonal @ (orthogonal.transpose(0, 2, 1) @ values)
    return float(np.max(np.quantile(np.sqrt(np.mean(left**2, axis=1)), _FAST, axis=0)))
