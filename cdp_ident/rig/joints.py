"""From the encoders' counters to the positions of the joints."""

import math
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

from cdp_ident.errors import RigError
from cdp_ident.rig.codec import UNSIGNED_32
from cdp_ident.rig.records import Hello, Sample

HANGING = (0.0, math.pi, 0.0)
"""Positions of cart [m], inner and outer joint [rad] where the pendulum hangs: both rods down, the cart at its zero."""
REST_SECONDS = 1.0
"""How long the pendulum must rest before its position is taken as hanging [s]."""
_REST_US = round(REST_SECONDS * 1e6)
_BELIEVED_AFTER = 3
"""A jump past the slew limit is believed when this many samples in a row agree on it."""

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Calibration:
    """What turns counts into positions; everything is in the order cart, inner, outer."""

    signs: tuple[int, int, int] = (1, 1, 1)
    """-1 where the counter runs against the joint's positive direction."""
    metres_per_count: float = 1e-5
    inner_counts_per_turn: int = 0
    """0: what the rig's greeting says; likewise the next."""
    outer_counts_per_turn: int = 0
    slew_limits: Triple = (20.0, 100.0, 100.0)
    """Faster motion [m/s, rad/s, rad/s] is a fault of an encoder, not of the pendulum."""
    rest_limits: Triple = (0.001, 0.01, 0.01)
    """Within these [m, rad, rad] over a second, the pendulum is at rest (or within 2 counts if those are more)."""

    def counts_per_turn(self, hello: Hello | None) -> tuple[int, int]:
        """Return the counts per turn of the inner and outer encoder, 0 where neither user nor rig has given them."""
        said = (hello.inner_counts, hello.outer_counts) if hello else (0, 0)
        return self.inner_counts_per_turn or said[0], self.outer_counts_per_turn or said[1]

    def needs_greeting(self) -> bool:
        """Tell whether the rig's greeting is needed to know the counts per turn."""
        return 0 in self.counts_per_turn(None)

    def scales(self, hello: Hello | None) -> Triple:
        """Return what one count is, with its sign [m, rad, rad]. Raises `RigError` where that is not known."""
        inner, outer = self.counts_per_turn(hello)
        if not inner or not outer:
            raise RigError("the counts per turn are not known: the rig sent no greeting, so set them as parameters")
        sizes = (self.metres_per_count, math.tau / inner, math.tau / outer)
        cart, inner_scale, outer_scale = (sign * size for sign, size in zip(self.signs, sizes, strict=True))
        return cart, inner_scale, outer_scale


class _Counted(NamedTuple):
    time_us: int
    raw: tuple[int, int, int]
    counts: tuple[int, int, int]
    """The counters without their roll-over."""


class JointTracker:
    """Follows the joints of one run of the device: removes roll-over and jumps, and applies scale and zero."""

    def __init__(self, scales: Triple, calibration: Calibration, zero: Triple) -> None:
        """`zero` are the counts at which the pendulum hangs."""
        self.zero = zero
        self.jumps_dropped = 0
        """Samples dropped because a joint moved faster than its slew limit."""
        self._scales = scales
        self._fastest = [abs(limit / scale) for limit, scale in zip(calibration.slew_limits, scales, strict=True)]
        """Counts in a second."""
        self._rest = calibration.rest_limits
        self._last: _Counted | None = None
        self._jumped: list[_Counted] = []
        self._recent: deque[_Counted] = deque()

    def positions(self, sample: Sample) -> Triple | None:
        """Return the positions [m, rad, rad] of a sample, None where it is dropped as an impossible jump."""
        raw = (sample.cart, sample.inner, sample.outer)
        now = self._counted(sample.time_us, raw)
        if self._last is not None and self._too_fast(self._last, now):
            if self._jumped and self._too_fast(self._jumped[-1], now):
                self._jumped.clear()
            self._jumped.append(now)
            if len(self._jumped) < _BELIEVED_AFTER:
                self.jumps_dropped += 1
                return None
        self._jumped.clear()
        self._last = now
        self._recent.append(now)
        while (now.time_us - self._recent[0].time_us) & UNSIGNED_32 > _REST_US:
            self._recent.popleft()
        cart, inner, outer = [
            hanging + scale * (count - zero)
            for hanging, scale, count, zero in zip(HANGING, self._scales, now.counts, self.zero, strict=True)
        ]
        return cart, inner, outer

    def resting_counts(self) -> Triple:
        """Return the mean counts of the last second. Raises `RigError` where the pendulum moved in it."""
        if not self._recent or _seconds(self._recent[0], self._recent[-1]) < 0.9 * REST_SECONDS:
            raise RigError(f"less than {REST_SECONDS:g} s of samples have come: try again in a moment")
        columns = list(zip(*(counted.counts for counted in self._recent), strict=True))
        for name, unit, column, scale, limit in zip(
            ("cart", "inner joint", "outer joint"), ("m", "rad", "rad"), columns, self._scales, self._rest, strict=True
        ):
            counts = max(column) - min(column)
            if counts > 2 and counts * abs(scale) > limit:
                raise RigError(
                    f"the {name} moved by {counts * abs(scale):.4g} {unit} in the last {REST_SECONDS:g} s (limit "
                    f"{limit:g} {unit}): let the pendulum hang at rest and try again"
                )
        cart, inner, outer = (sum(column) / len(column) for column in columns)
        return cart, inner, outer

    def _counted(self, time_us: int, raw: tuple[int, int, int]) -> _Counted:
        # At first, the counts are the ones next to the zero: the counters may have rolled over since it was taken.
        before_raw = self._last.raw if self._last else [round(zero) for zero in self.zero]
        before = self._last.counts if self._last else before_raw
        cart, inner, outer = [
            count + ((new - old + 2**31) & UNSIGNED_32) - 2**31
            for count, new, old in zip(before, raw, before_raw, strict=True)
        ]
        return _Counted(time_us, raw, (cart, inner, outer))

    def _too_fast(self, before: _Counted, after: _Counted) -> bool:
        elapsed = max(_seconds(before, after), 1e-6)
        for new, old, speed in zip(after.counts, before.counts, self._fastest, strict=True):
            if abs(new - old) > max(2, speed * elapsed):
                return True
        return False


def _seconds(before: _Counted, after: _Counted) -> float:
    return ((after.time_us - before.time_us) & UNSIGNED_32) * 1e-6
