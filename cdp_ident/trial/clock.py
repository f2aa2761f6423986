# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When samples were measured evenly, by a clock that steps or by stamps that are not even.

A clock that is set moves both joints at once, as fast as they are: the motion goes on as after a usual interval, and
not as after that of the stamps. Where samples are lost or late, the stamps' interval is the true one.
"""

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.trial.bursts import (
    COARSEST,
    DIGITS,
    FEWEST,
    GAP,
    LONGEST_WAIT,
    UNEVEN,
    evened,
    last_digit,
    off_cubics,
    usual_wait,
)
from cdp_ident.trial.kinematics import SAME

_ODD = 10.0
"""An interval is odd where it is off the usual one by so many times what intervals are off it by (median)."""
_CLEAR = 2.0
"""Motion is as after one interval and not the other where it is rougher after this by so many times what is usual."""
_AS_SMOOTH = 1.2
"""Where motion tells nothing, it is no rougher than this by one of both."""
_BY_CHANCE = 2
"""So many steps of a clock may all be ahead, or back, by chance."""
_TOLD, _LOOKED_AT = 3, 4096
_NEAR = 8
"""Samples before and after a step that tell it."""
_AS_STAMPED = ((0, 0),)


def measured_times(time: Array, angles: Array, parts: Indices) -> tuple[Array, list[str], float]:
    """Return times of samples (n,) [s], what there is to say, and how sure their pace is, as a share (`evened`).

    They are even where samples were measured evenly, and without the steps of their clock. They are stamped at `time`
    (n,), ascending [s], and show `angles` (n, k) [rad]; `parts` are the first samples after the clock was set back.
    """
    if np.all(np.diff(time) <= GAP * usual_wait(time)):
        times, notes, pace_std = evened(time, angles, parts, GAP)
        if notes:
            return times, notes, pace_std
    without, notes, digit = _without_steps(time, angles, parts)
    for gap in (np.inf, GAP):
        times, more, pace_std = evened(without, angles, parts, gap, digit)
        if more:
            break
    return times, [*notes, *more], pace_std


def _without_steps(time: Array, angles: Array, parts: Indices) -> tuple[Array, list[str], float]:
    """Return times of samples (n,) without the steps of their clock, and what there is to say about these.

    The last value is the digit that the clock shows where so many steps are one of its digits each; else 0.
    """
    intervals = np.diff(time)
    if len(intervals) < FEWEST or (usual := float(np.median(intervals))) <= 0.0:
        return time, [], 0.0
    off = intervals - usual
    odd = np.abs(off) > max(UNEVEN * usual, _ODD * float(np.median(np.abs(off))), DIGITS * last_digit(time))
    if np.sum(intervals[~odd]) < np.sum(np.minimum(intervals, LONGEST_WAIT)[odd]):  # bursts
        return time, [], 0.0
    odd[parts - 1] = True
    alone = odd & (np.convolve(odd, np.ones(2 * _NEAR + 1), mode="same") < 1.5)
    alone[[*range(_NEAR - 1), *range(len(odd) - _NEAR + 1, len(odd))]] = alone[parts - 1] = False
    continuous, places = np.asarray(np.unwrap(angles, axis=0)), np.flatnonzero(alone) + 1
    too_long = _of_clock(time, continuous, places, usual)
    steps = np.flatnonzero(too_long)
    largest = float(np.max(np.abs(too_long)))
    if len(steps) > _BY_CHANCE and np.ptp(np.sign(too_long[steps])) == 0.0 and largest < COARSEST * usual:
        return time, [], largest  # samples are measured at another pace than it shows
    if not len(steps):
        return time, [], 0.0
    shown = [f"{off[at]:.3g} s at {time[at]:.3f} s" for at in steps[:_TOLD]]
    more = f" and {len(steps) - _TOLD} more times" if len(steps) > _TOLD else ""
    note = f"the clock steps by {', '.join(shown)}{more}: taken out, as the motion goes on without them"
    return time - np.append(0.0, np.cumsum(too_long)), [note], 0.0


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
