# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Times by a clock that steps, or shows only its last digit, while samples are measured evenly.

A clock that is set moves both joints at once, as fast as they are: the motion goes on as after a usual interval, and
not as after that of the stamps. Where samples are lost or late, the stamps' interval is the true one.
"""

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.trial.bursts import FEWEST, LONGEST_WAIT, UNEVEN, off_cubics
from cdp_ident.trial.kinematics import SAME

_ODD = 10.0
"""An interval is odd where it is off the usual one by so many times what intervals are off it by (median)."""
_CLEAR = 2.0
"""Motion is as after one interval and not the other where it is rougher after this by so many times what is usual."""
_AS_SMOOTH = 1.2
"""Where motion tells nothing, it is no rougher than this by one of both."""
_DIGITS, _COARSEST = 1.25, 0.75
"""Rounded, even times lie within so many of their last digits about a line; and how many intervals a digit is at most.
"""
_BY_CHANCE = 2
"""So many steps of a clock may all be ahead, or back, by chance."""
_TOLD, _LOOKED_AT = 3, 4096
_NEAR = 8
"""Samples before and after a step that tell it."""
_AS_STAMPED = ((0, 0),)


def evenly_clocked(time: Array, angles: Array, parts: Indices) -> tuple[Array, list[str]]:
    """Return times of samples (n,) [s] by a clock that goes evenly, and what there is to say about it.

    They are stamped at `time` (n,), ascending [s], and show `angles` (n, k) [rad]; `parts` are the first samples after
    the clock was set back. Steps of the clock are taken out, and times that are rounded are taken evenly.
    """
    intervals = np.diff(time)
    if len(intervals) < FEWEST or (usual := float(np.median(intervals))) <= 0.0:
        return time, []
    digit = 1e-6 * float(np.gcd.reduce(np.round(1e6 * time).astype(np.int64)))
    digit = digit if digit < _COARSEST * usual else 0.0
    off = intervals - usual
    odd = np.abs(off) > max(UNEVEN * usual, _ODD * float(np.median(np.abs(off))), _DIGITS * digit)
    if np.sum(intervals[~odd]) < np.sum(np.minimum(intervals, LONGEST_WAIT)[odd]):  # bursts
        return time, []
    odd[parts - 1] = True
    alone = odd & (np.convolve(odd, np.ones(2 * _NEAR + 1), mode="same") < 1.5)
    alone[[*range(_NEAR - 1), *range(len(odd) - _NEAR + 1, len(odd))]] = alone[parts - 1] = False
    continuous, places = np.asarray(np.unwrap(angles, axis=0)), np.flatnonzero(alone) + 1
    too_long = _of_clock(time, continuous, places, usual)
    steps, largest = np.flatnonzero(too_long), float(np.max(np.abs(too_long)))
    if len(steps) > _BY_CHANCE and np.ptp(np.sign(too_long[steps])) == 0.0 and largest < _COARSEST * usual:
        # The clock that shows so little runs at another pace than its usual intervals tell.
        digit, steps, too_long = largest, steps[:0], np.zeros(len(too_long))
    notes, times = [], time - np.append(0.0, np.cumsum(too_long))
    if len(steps):
        shown = [f"{off[at]:.3g} s at {time[at]:.3f} s" for at in steps[:_TOLD]]
        more = f" and {len(steps) - _TOLD} more times" if len(steps) > _TOLD else ""
        notes.append(f"the clock steps by {', '.join(shown)}{more}: taken out, as the motion goes on without them")
    if digit > UNEVEN * usual:
        for part in np.split(np.arange(len(time)), parts):
            even, step = _even(times[part], digit)
            times[part] = even - even[0] + times[max(0, part[0] - 1)]
            if step:
                notes.append(f"times are rounded to {1e3 * digit:.3g} ms: taken evenly, {1e3 * step:.4g} ms apart")
    return times, notes


def _of_clock(time: Array, angles: Array, places: Indices, usual: float) -> Array:
    """Return by how much each interval (n - 1,) is too long by a step of the clock before some of the `places` [s]."""
    too_long = np.zeros(len(time) - 1)
    if not len(places):
        return too_long
    too_long[places - 1] = time[places] - time[places - 1] - usual
    some = np.arange(_NEAR, len(time) - _NEAR + 1, 1 + len(time) // _LOOKED_AT)
    even = time - np.append(0.0, np.cumsum(too_long))
    usually, stamped, evenly = (
        off_cubics(of / usual, angles, at, _AS_STAMPED, _NEAR)[:, 0]
        for of, at in ((time, some), (time, places), (even, places))
    )
    # An encoder at rest says the same again and again.
    noise = float(np.median(usually[usually > SAME])) if np.any(usually > SAME) else 0.0
    clear = (_CLEAR * noise) ** 2
    told = (evenly < _CLEAR * noise) & (stamped**2 > evenly**2 + clear)
    # Slow motion tells nothing. No sample is lost there, and none is measured too early, or the clock is known to step,
    # but where samples are measured at such intervals elsewhere.
    steps = (time[places] - time[places - 1]) / usual
    is_odd = np.abs(steps - np.round(steps)) > UNEVEN
    if not np.any(is_odd & (evenly**2 > stamped**2 + clear)):
        possible = is_odd & (np.any(told) | (steps < 1.0))
        told |= possible & (evenly < _CLEAR * noise) & (evenly < _AS_SMOOTH * stamped)
    too_long[places[~told] - 1] = 0.0
    return too_long


def _even(time: Array, digit: float) -> tuple[Array, float]:
    """Return even times of samples at rounded times (n,), and their distance; those given, and 0, if these are not."""
    steps = np.diff(time)
    if len(steps) < FEWEST:
        return time, 0.0
    usual = np.mean(steps[steps < 1.5 * np.median(steps)])
    count = np.append(0.0, np.cumsum(np.round(steps / usual)))
    step, first = np.polyfit(count, time, 1)
    even = first + step * count
    return (even, float(step)) if np.ptp(time - even) < _DIGITS * digit else (time, 0.0)
