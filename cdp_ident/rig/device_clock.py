# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a sample was measured: the device's clock mapped to the host's, past the delays of the line."""

import math
from collections import deque

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.bag.device_messages import ClockRate
from cdp_ident.rig.protocol import UNSIGNED_32, signed_32

_BUCKET = 0.25
"""The least delayed arrival in each stretch this long is what the fit sees [s]."""
_WARM_UP, _LONGEST_WARM_UP = 1.0, 5.0
"""Before this much is seen, first delays could be mistaken for the offset [s]; more while a backlog is caught up."""
_CATCHING_UP = 0.002
"""A backlog is being caught up while delays still become shorter by this much [s]."""
_WINDOW = 60.0
"""How far back the fit looks: crystals drift with temperature over minutes [s]."""
_RECENT = 10.0
"""The offset is that of the least delayed arrival in this time [s]: the rate is not sure enough for older ones."""
_LARGEST_RATE = 0.01
"""Ceramic resonators are off by up to 0.5 %."""
_SETTLE, _LARGEST_SETTLING = 5.0, 5e-4
"""A better offset is approached with this time constant [s], and by no more than this much per second."""
_EARLY, _LATE, _LATE_FOR = 0.02, 0.05, 5.0
"""An arrival this much before its own measurement [s], or nothing but arrivals this late for so long, say that one
of the clocks was set: the fit starts anew."""
_GAP = 1.0
"""A silence of the device this long starts the fit anew [s]."""

_RATE_BUCKETS = 4
"""The rate is from the least delayed arrivals of so many buckets together …"""
_FEWEST_FOR_RATE = 5
"""… and of so many such arrivals at least: before, delays say more about the difference in rate than the clocks do."""

Point = tuple[float, float]


class DeviceClock:
    """Maps the device's 32-bit microsecond clock to the host's nanoseconds by a running fit of offset and rate.

    A message can be late but never early, so the truth is a line below all points (device time, arrival - device
    time) that touches the least delayed ones, with the slope that these have. Between updates, four a second, the
    mapping is a straight line, and it has no steps: stamps keep the device's spacing. After a reset, make a new one.
    """

    def __init__(self, simulated: bool = False) -> None:
        """`simulated` is for a host clock that follows the device's by construction (`use_sim_time`).

        Such a clock goes in steps that may come after the bytes, so arrivals can be early and say nothing about
        rates: the offset found in the warm-up is kept.
        """
        self._simulated = simulated
        self._origin_ns = self._first_us = 0
        """The host's time when the first sample arrived, and the device's own of it."""
        self._last_us: int | None = None
        self._unrolled_us = 0
        self._bucket_end = 0.0
        self._best: Point | None = None
        self._buckets: deque[Point] = deque()
        self._late_buckets = 0
        self._anchor: Point | None = None
        self._rate = 0.0

    @property
    def ready(self) -> bool:
        """Whether enough is seen for `stamp` to be used."""
        return self._anchor is not None

    def is_new_run(self, time_us: int, arrival_ns: int) -> bool:
        """Tell whether a sample cannot belong to this mapping, so that a new one is due for it.

        That is so after a long silence of the device, or when one of the clocks was set.
        """
        if self._last_us is None:
            return False
        if ((time_us - self._last_us) & UNSIGNED_32) * 1e-6 > _GAP:
            return True
        if self._anchor is None or self._simulated:
            return False
        device = (self._unrolled_us + ((time_us - self._last_us) & UNSIGNED_32)) * 1e-6
        early = self._offset(device) - self._delay(device, arrival_ns) > _EARLY
        return early or self._late_buckets * _BUCKET > _LATE_FOR

    def observe(self, time_us: int, arrival_ns: int) -> None:
        """Take the device's time of a sample and the host's time when it arrived, in the order of the device."""
        if self._last_us is None:
            self._origin_ns, self._first_us, self._last_us = arrival_ns, time_us, time_us
        self._unrolled_us += (time_us - self._last_us) & UNSIGNED_32
        self._last_us = time_us
        device = self._unrolled_us * 1e-6
        point = (device, self._delay(device, arrival_ns))
        if device >= self._bucket_end:
            if self._best is not None:
                self._close_bucket(device)
            self._bucket_end = device + _BUCKET
            self._best = point
        elif self._best is None or point[1] < self._best[1]:
            self._best = point

    def times(self, time_us: int) -> tuple[int, int]:
        """Return the host's time of a device time, and that itself with its roll-overs counted [ns].

        It is at most half a roll-over from the last observed one. Raises ValueError where none was observed.
        """
        if self._last_us is None:
            raise ValueError("nothing observed yet")
        elapsed = self._unrolled_us + signed_32(time_us - self._last_us)
        stamp = self._origin_ns + elapsed * 1000 + round(self._offset(elapsed * 1e-6) * 1e9)
        return stamp, (self._first_us + elapsed) * 1000

    def rate(self) -> ClockRate | None:
        """Return how fast the device's clock runs by the last minute; None while too little was seen.

        It is the median of the slopes between the least delayed arrivals of each second, with the interval that goes
        with it (Theil 1950; Sen, J. Am. Stat. Assoc. 63, 1968).
        """
        if self._simulated:
            return ClockRate(0.0, 0.0)
        points = list(self._buckets)
        least = [
            min(points[first : first + _RATE_BUCKETS], key=lambda point: point[1])
            for first in range(0, len(points) - _RATE_BUCKETS + 1, _RATE_BUCKETS)
        ]
        if len(least) < _FEWEST_FOR_RATE:
            return None
        device, delay = np.array(least).T
        slope, low, high = median_slope(device, delay)
        return ClockRate(-slope / (1.0 + slope), (high - low) / 2.0)

    def _delay(self, device: float, arrival_ns: int) -> float:
        return (arrival_ns - self._origin_ns) * 1e-9 - device

    def _offset(self, device: float) -> float:
        if self._anchor is None:
            return min((delay for _, delay in self._buckets), default=self._best[1] if self._best else 0.0)
        return self._anchor[1] + (device - self._anchor[0]) * self._rate

    def _close_bucket(self, now: float) -> None:
        assert self._best is not None
        self._buckets.append(self._best)
        while self._buckets[0][0] < now - _WINDOW:
            self._buckets.popleft()
        if self._anchor is None and self._is_warming_up(now):
            return
        if self._simulated:
            self._anchor = self._anchor or (now, min(delay for _, delay in self._buckets))
            return
        rate, offset = self._line_below(now)
        if self._anchor is None:
            self._anchor = (now, offset)
            self._rate = rate
            return
        late = self._best[1] - self._offset(self._best[0]) > _LATE
        self._late_buckets = self._late_buckets + 1 if late else 0
        self._anchor = (now, self._offset(now))
        settling = (offset - self._anchor[1]) / _SETTLE
        self._rate = rate + min(max(settling, -_LARGEST_SETTLING), _LARGEST_SETTLING)

    def _is_warming_up(self, now: float) -> bool:
        if now < _WARM_UP or len(self._buckets) < 2:
            return True
        *before, (_, last) = self._buckets
        return now < _LONGEST_WARM_UP and last < min(delay for _, delay in before) - _CATCHING_UP

    def _line_below(self, now: float) -> tuple[float, float]:
        """Return slope and present height of the line below the least delayed arrivals.

        The slope is shrunk towards none as far as it is uncertain, which it is at first.
        """
        slope = 0.0
        if (rate := self.rate()) and rate.fast:
            slope = min(max(-rate.fast / (1.0 + rate.fast), -_LARGEST_RATE), _LARGEST_RATE)
            slope *= slope**2 / (slope**2 + rate.std**2)
        return slope, min(delay + slope * (now - device) for device, delay in self._buckets if device >= now - _RECENT)


def median_slope(x: Array, y: Array) -> tuple[float, float, float]:
    """Return the slope of y (n,) over x (n,), and the ends of the interval of one standard deviation about it.

    The slope is Theil's (1950). The interval is Sen's (J. Am. Stat. Assoc. 63, 1968): Kendall's rank correlation of
    what the line leaves is none within it. `scipy.stats.theilslopes` gives the same, but to load it takes longer than
    all else of a driver, whose samples wait meanwhile. x increases strictly, and has two values at least.
    """
    earlier, later = np.triu_indices(len(x), 1)
    slopes = np.sort((y[later] - y[earlier]) / (x[later] - x[earlier]))
    _, alike = np.unique(y, return_counts=True)
    # The variance of Kendall's score, which values that are alike diminish.
    whole, *parts = (count * (count - 1) * (2 * count + 5) / 18.0 for count in (len(y), *alike.tolist()))
    std = math.sqrt(max(whole - sum(parts), 0.0))
    low = max(round((len(slopes) - std) / 2.0) - 1, 0)
    high = min(round((len(slopes) + std) / 2.0), len(slopes) - 1)
    return float(np.median(slopes)), float(slopes[low]), float(slopes[high])
