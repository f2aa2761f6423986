# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When the pendulum is let go, and when it has come to rest."""

import math
from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import Annotated

from cdp_ident.rig.joints import HANGING
from cdp_ident.user_input import Limits

_HOLD_SECONDS, _REST_SECONDS = 0.3, 1.0
_RELEASE_WITHIN = 0.5
"""A hand that moves the pendulum more slowly than this [s] out of its hold has not let it go."""
_HELD_FOR = 4.0
"""A pendulum that was held stayed there so many times as long as it then takes to get away from there. One that turned
back stayed about twice as long, however far and fast it swings: its angle is a parabola there."""


class End(Enum):
    """Why a trial ended."""

    AT_REST = "the pendulum came to rest"
    CAUGHT = "the pendulum was caught"
    TIME_OUT = "it lasted as long as it may"
    SILENCE = "no joint states came any more"
    STOPPED = "it was stopped"
    FAILED = "the disk did not take it"


@dataclass(frozen=True)
class TrialLimits:
    """What counts as held, let go and at rest."""

    hold_limit: Annotated[float, Limits(0.0, 1.0)] = 0.03
    """Held: both joints stay within this for 0.3 s [rad]."""
    away_limit: Annotated[float, Limits(0.0, 3.0)] = 0.15
    """Held, not hanging: a rod is this far from hanging [rad]."""
    release_limit: Annotated[float, Limits(0.0, 3.0)] = 0.1
    """Let go: a joint is this far from its hold [rad]."""
    rest_limit: Annotated[float, Limits(0.0, 1.0)] = 0.01
    """At rest: both joints stay within this for 1 s, and both rods hang [rad]."""
    longest: Annotated[float, Limits(0.0, 86400.0)] = 60.0
    """A trial ends after this, wherever the pendulum is [s]."""
    silence: Annotated[float, Limits(0.0, 60.0)] = 5.0
    """A trial ends where samples are missing for longer [s]."""


class SlidingRange:
    """The difference between the largest and the smallest value of the last so many seconds.

    Where no value comes for half that time, or time goes back, nothing is known of what was between: it begins anew.
    """

    def __init__(self, seconds: float) -> None:
        self._span_ns = round(seconds * 1e9)
        self._first_ns = self._last_ns = 0
        self._lows: list[deque[tuple[int, float]]] = []
        """What may still become the smallest, of each value and of its negative."""

    def update(self, stamp_ns: int, *values: float) -> float:
        """Take the next values; return the largest of their ranges, infinity while less than the span was seen."""
        of_both = [sign * value for value in values for sign in (1.0, -1.0)]
        if not self._lows or not 0 <= stamp_ns - self._last_ns <= self._span_ns // 2:
            self._lows, self._first_ns = [deque() for _ in of_both], stamp_ns
        self._last_ns = stamp_ns
        for lows, value in zip(self._lows, of_both, strict=True):
            while lows and lows[-1][1] >= value:
                lows.pop()
            lows.append((stamp_ns, value))
            while lows[0][0] < stamp_ns - self._span_ns:
                lows.popleft()
        if stamp_ns - self._first_ns < self._span_ns:
            return math.inf
        lowest = [lows[0][1] for lows in self._lows]
        return max(-low - high for low, high in zip(lowest[::2], lowest[1::2], strict=True))


class ReleaseDetector:
    """Notices that the pendulum was held away from hanging and is let go."""

    def __init__(self, limits: TrialLimits) -> None:
        self._limits = limits
        self._range = SlidingRange(_HOLD_SECONDS)
        self._last_ns = self._still_since = self._still_until = 0
        self._place: tuple[float, float] | None = None
        """Where it was held until then; None while it is not held."""

    def update(self, stamp_ns: int, inner: float, outer: float) -> bool:
        """Take the next positions [rad]; return whether this is the first one seen to be free."""
        gap, self._last_ns = stamp_ns - self._last_ns, stamp_ns
        if gap < 0 or (gap > _HOLD_SECONDS / 2 * 1e9 and self._is_near(inner, outer)):
            self._still_since += gap  # a hold goes on as if there had been no gap: it is still there, or time went back
            self._still_until += gap
        if self._range.update(stamp_ns, inner, outer) <= self._limits.hold_limit:
            if _from_hanging(inner, outer) <= self._limits.away_limit:
                self._place = None
                return False
            if self._place is None:
                self._still_since = stamp_ns - round(_HOLD_SECONDS * 1e9)
            self._still_until, self._place = stamp_ns, (inner, outer)
            return False
        if self._place is None:
            return False
        leaving = stamp_ns - self._still_until
        if not self._is_near(inner, outer):
            self._place = None
            return self._still_until - self._still_since > _HELD_FOR * leaving
        if leaving > _RELEASE_WITHIN * 1e9:
            self._place = None
        return False

    def _is_near(self, inner: float, outer: float) -> bool:
        """Tell whether the pendulum is about where it was held."""
        return self._place is not None and _moved(self._place, inner, outer) <= self._limits.release_limit


class EndDetector:
    """Notices that a pendulum that moved rests or is held, or that the trial has lasted long enough."""

    def __init__(self, limits: TrialLimits, start_ns: int, ends_when_caught: bool = True) -> None:
        self._limits = limits
        self._start_ns = self._last_ns = start_ns
        self._ends_when_caught = ends_when_caught
        self._first: tuple[float, float] | None = None
        self._moved = False
        self._range = SlidingRange(_REST_SECONDS)

    def update(self, stamp_ns: int, inner: float, outer: float) -> End | None:
        """Take the next positions [rad]; return why the trial ends here, None while it goes on."""
        gap, self._last_ns = stamp_ns - self._last_ns, stamp_ns
        self._start_ns += min(gap, 0)  # what has passed counts on where time goes back
        if gap > self._limits.silence * 1e9:
            return End.SILENCE
        first = self._first = self._first or (inner, outer)
        self._moved |= _moved(first, inner, outer) > self._limits.release_limit
        moved = self._range.update(stamp_ns, inner, outer)
        hangs = _from_hanging(inner, outer) < self._limits.away_limit
        if self._moved and moved <= self._limits.rest_limit and hangs:
            return End.AT_REST
        if self._moved and moved <= self._limits.hold_limit and not hangs and self._ends_when_caught:
            return End.CAUGHT
        return End.TIME_OUT if stamp_ns - self._start_ns > self._limits.longest * 1e9 else None


def _moved(place: tuple[float, float], inner: float, outer: float) -> float:
    """Return how far the joint is from a place that is farther from it [rad]."""
    return max(abs(inner - place[0]), abs(outer - place[1]))


def _from_hanging(inner: float, outer: float) -> float:
    """Return how far the rod is from hanging that is farther from it [rad], whole turns left out."""
    _, hanging, _ = HANGING
    return max(abs(math.remainder(inner - hanging, math.tau)), abs(math.remainder(inner + outer - hanging, math.tau)))
