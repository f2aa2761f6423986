# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From the encoders' counters to the positions of the joints, and the counts at rest, kept when the driver ends."""

import math
from collections import deque
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import yaml

from cdp_ident.errors import OptionError, RigError
from cdp_ident.files import write_whole
from cdp_ident.rig.protocol import UNSIGNED_32, Hello, Sample, signed_32
from cdp_ident.user_input import Limits, of_fields
from cdp_ident.yaml_file import read_yaml

HANGING = (0.0, math.pi, 0.0)
"""Positions of cart [m], inner and outer joint [rad] where the pendulum hangs: both rods down, the cart at its zero."""
REST_SECONDS = 1.0
"""How long the pendulum must rest before its position is taken as hanging [s]."""
_REST_US = round(REST_SECONDS * 1e6)
_BELIEVED_AFTER = 3
"""A jump past the slew limit is believed when this many samples in a row agree on it."""

_NEW_ZERO = "delete it, let the pendulum hang and call ~/zero_hanging"

Triple = tuple[float, float, float]
_Sign = Annotated[int, Limits(-1, 1)]
_Counts = Annotated[int, Limits(0, 2**31)]
_MeanCounts = Annotated[float, Limits(-(2.0**63), 2.0**63)]
_Whole = Annotated[int, Limits(-(2**63), 2**63)]
_Slew = Annotated[float, Limits(0.01, 1e6)]
_Rest = Annotated[float, Limits(0.0, 1.0)]


@dataclass(frozen=True)
class Calibration:
    """What turns counts into positions.

    Raises `OptionError` where a sign is none.
    """

    cart_sign: _Sign = 1
    """-1 if the cart counter runs against +x."""
    inner_sign: _Sign = 1
    """-1 if the inner counter runs against +x."""
    outer_sign: _Sign = 1
    """-1 if the outer counter runs against +x."""
    metres_per_count: Annotated[float, Limits(1e-9, 1.0)] = 1e-5
    """The cart's way for one count [m]."""
    inner_counts_per_turn: _Counts = 0
    """Counts of the inner encoder per turn, four a line; 0: what the rig's greeting says."""
    outer_counts_per_turn: _Counts = 0
    """Counts of the outer encoder per turn, four a line; 0: what the rig's greeting says."""
    cart_slew_limit: _Slew = 20.0
    """Cart: faster motion is dropped as a fault [m/s]."""
    inner_slew_limit: _Slew = 100.0
    """Inner joint: faster motion is dropped as a fault [rad/s]."""
    outer_slew_limit: _Slew = 100.0
    """Outer joint: faster motion is dropped as a fault [rad/s]."""
    cart_rest_limit: _Rest = 0.001
    """Cart: moves less than this (or 2 counts) in a second at rest [m]."""
    inner_rest_limit: _Rest = 0.01
    """Inner joint: moves less than this (or 2 counts) in a second at rest [rad]."""
    outer_rest_limit: _Rest = 0.01
    """Outer joint: moves less than this (or 2 counts) in a second at rest [rad]."""

    def __post_init__(self) -> None:
        """Refuse what is no sign."""
        for name in ("cart_sign", "inner_sign", "outer_sign"):
            if getattr(self, name) == 0:
                raise OptionError(f"parameter '{name}' is 0; expected 1 or -1")

    @property
    def signs(self) -> tuple[int, int, int]:
        """Those of cart, inner and outer joint."""
        return self.cart_sign, self.inner_sign, self.outer_sign

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
        self._scales = scales
        fastest = (calibration.cart_slew_limit, calibration.inner_slew_limit, calibration.outer_slew_limit)
        self._fastest = [abs(limit / scale) for limit, scale in zip(fastest, scales, strict=True)]
        """Counts in a second."""
        self._rest = (calibration.cart_rest_limit, calibration.inner_rest_limit, calibration.outer_rest_limit)
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
            count + signed_32(new - old) for count, new, old in zip(before, raw, before_raw, strict=True)
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


@dataclass(frozen=True)
class Zero:
    """Counts at rest, hanging; and when they were taken, to know whether the device has run on since."""

    cart_counts: _MeanCounts
    """The mean over a second, so no whole number; likewise the next two."""
    inner_counts: _MeanCounts
    outer_counts: _MeanCounts
    sequence: _Whole
    """Sequence number of the device at that time."""
    taken_at_ns: _Whole
    """Host's time [ns since the epoch]."""

    @property
    def counts(self) -> Triple:
        """Those of cart, inner and outer encoder."""
        return self.cart_counts, self.inner_counts, self.outer_counts

    def is_of_this_run(self, sequence: int, now_ns: int, period_us: int) -> bool:
        """Tell whether the device's sequence number says that it was not reset since the zero was taken."""
        elapsed = (now_ns - self.taken_at_ns) * 1e-9
        counted = (sequence - self.sequence) % 2**32 * period_us * 1e-6
        turn = 2**32 * period_us * 1e-6
        error = (counted - elapsed + turn / 2) % turn - turn / 2
        return elapsed >= -5.0 and abs(error) < 5.0 + 0.01 * elapsed


def load_zero(path: Path) -> Zero | None:
    """Return the zero kept in a file, None where there is no file yet.

    Raises `RigError` where the file is there but is not a zero: guessing would falsify every angle.
    """
    try:
        return of_fields(read_yaml(path), Zero, f"the zero kept in {path}")
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise RigError(f"the zero kept in {path} cannot be read: {error}; {_NEW_ZERO}") from error
    except OptionError as error:
        raise RigError(f"{error}; {_NEW_ZERO}") from error


def save_zero(path: Path, zero: Zero) -> None:
    """Keep a zero in a file, which is replaced as a whole. Raises `RigError` where it cannot be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole({path: yaml.safe_dump(asdict(zero), sort_keys=False).encode()})
    except OSError as error:
        raise RigError(f"the zero cannot be kept in {path}: {error.strerror or error}") from error
