# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a trial while it is recorded, and warnings for the user."""

import json
import math
import struct
from array import array
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from cdp_ident.bag.joint_state import HEAD_OFFSET, NANOSECONDS, STAMP_OFFSET, Layout, parse_layout
from cdp_ident.bag.metadata import RIG_NAME, UNKNOWN
from cdp_ident.model.weights import ADDED, Weight, settings_of
from cdp_ident.rig.recording.detector import End, TrialLimits
from cdp_ident.user_input import Limits

_GAP = 1.5
"""Two samples more than this many usual periods apart have lost others between them."""
_LARGEST = 1e6
"""A position beyond this [rad, m] is no pendulum's; what is not a number is not either."""


@dataclass(frozen=True)
class JointNames:
    """Which joints of a JointState are the pendulum's."""

    cart_joint: str = "cart_joint"
    """Name of the cart's joint; empty if it has no encoder."""
    inner_joint: str = "inner_joint"
    """Name of the joint between cart and inner rod."""
    outer_joint: str = "outer_joint"
    """Name of the joint between the rods."""


@dataclass(frozen=True)
class Position:
    """The pendulum in one message."""

    stamp_ns: int
    inner: float
    outer: float
    cart: float | None
    torques: tuple[float, float] | None = None
    """Of motors in the inner and the outer joint [N m]; None where there are none, or they are not read."""


class PositionReader:
    """Reads the pendulum's position from the bytes of JointState messages."""

    def __init__(self, joints: JointNames, with_torques: bool = False) -> None:
        self._joints, self._with_torques = joints, with_torques
        self._layout: Layout | None = None

    def read(self, raw: bytes) -> Position | None:
        """Return the position, None where the message does not hold both joints of the pendulum, or no number."""
        try:
            if self._layout is None or not raw.startswith(self._layout.head, HEAD_OFFSET):
                self._layout = parse_layout(raw)
            layout = self._layout
            seconds, nanoseconds = layout.stamp.unpack_from(raw, STAMP_OFFSET)
            values = dict(zip(layout.names, layout.positions.unpack_from(raw, layout.offset), strict=True))
            inner, outer = values[self._joints.inner_joint], values[self._joints.outer_joint]
            torques = self._torques(layout, raw) if self._with_torques else None
        except (ValueError, KeyError, struct.error):
            return None
        cart = values.get(self._joints.cart_joint)
        if not all(abs(value) <= _LARGEST for value in (inner, outer, cart or 0.0, *(torques or ()))):
            return None
        return Position(seconds * NANOSECONDS + nanoseconds, inner, outer, cart, torques)

    def _torques(self, layout: Layout, raw: bytes) -> tuple[float, float] | None:
        if not (efforts := layout.efforts(raw)):
            return None
        of = dict(zip(layout.names, layout.positions.unpack(efforts), strict=True))
        return of[self._joints.inner_joint], of[self._joints.outer_joint]


@dataclass(frozen=True)
class RecorderOptions:
    """What to record, where, and what counts as a trial."""

    folder: Path = Path("trials")
    """Where bags go, each in a folder of its own."""
    name: str = "trial"
    """What names of bags begin with; the time follows."""
    joints: JointNames = field(default_factory=JointNames)
    limits: TrialLimits = field(default_factory=TrialLimits)
    pre_trigger: Annotated[float, Limits(0.0, 60.0)] = 1.0
    """How much from before the release is kept [s]."""
    cart_limit: Annotated[float, Limits(0.0, 10.0)] = 0.002
    """With more motion of the cart a trial is not zero-input [m]."""
    shortest: Annotated[float, Limits(0.0, 3600.0)] = 5.0
    """A shorter trial is of little use [s]."""
    rearm: bool = False
    """Arm at the start and after each trial without being asked."""


@dataclass
class TrialFacts:
    """Collected from the samples of one trial."""

    options: RecorderOptions
    released_ns: int
    """Stamp of the first free sample, or of the start by hand."""
    started_by_hand: bool
    rig: dict[str, str] = field(default_factory=dict)
    weights: tuple[Weight, ...] = ()
    """That were clamped to the rods."""
    stamps: "array[int]" = field(default_factory=lambda: array("q"))
    cart_low: float = math.inf
    cart_high: float = -math.inf

    def take(self, position: Position) -> None:
        """Take the next sample."""
        self.stamps.append(position.stamp_ns)
        if position.cart is not None and position.stamp_ns >= self.released_ns:
            self.cart_low = min(self.cart_low, position.cart)
            self.cart_high = max(self.cart_high, position.cart)

    @property
    def cart_motion(self) -> float | None:
        """How far the cart moved after the release [m], None where it is not measured."""
        return self.cart_high - self.cart_low if self.cart_high >= self.cart_low else None

    @property
    def duration(self) -> float:
        """Time from the release to the last sample [s]."""
        return (self.stamps[-1] - self.released_ns) * 1e-9 if self.stamps else 0.0

    def lost(self) -> int:
        """Return how many samples are missing, by the gaps between stamps."""
        steps = self._steps()
        steps = steps[steps > 0]
        if len(steps) < 2:
            return 0
        periods = steps / np.median(steps)
        return int(np.sum(np.round(periods[periods > _GAP]) - 1))

    def longest_gap(self) -> float:
        """Return the longest time from one sample to the next [s], 0 where there are none."""
        return float(np.max(self._steps(), initial=0)) * 1e-9

    def _steps(self) -> "np.ndarray[tuple[int, ...], np.dtype[Any]]":
        return np.diff(np.array(self.stamps, dtype=np.int64))

    def unevenness(self) -> tuple[float, float]:
        """Return how far the stamps are from even spacing [s]: root mean square, and at most."""
        stamps = np.unique(np.array(self.stamps, dtype=np.int64))
        steps = np.diff(stamps)
        if len(steps) < 2:
            return 0.0, 0.0
        number = np.concatenate([[0.0], np.cumsum(np.round(steps / np.median(steps)))])
        seconds = (stamps - stamps[0]) * 1e-9
        off = seconds - np.polyval(np.polyfit(number, seconds, 1), number)
        return float(np.sqrt(np.mean(off**2))), float(np.max(np.abs(off)))

    def warnings(self) -> list[str]:
        """Return what is wrong with the trial, in words."""
        found = []
        motion, lost = self.cart_motion, self.lost()
        if motion is not None and motion > self.options.cart_limit:
            found.append(f"not zero-input: the cart moved by {motion:.4g} m (limit {self.options.cart_limit:g} m)")
        if lost:
            missing = f"the longest gap is {self.longest_gap():.3f} s"
            found.append(f"{lost} of {len(self.stamps) + lost} samples are lost, {missing}")
        if back := int(np.sum(self._steps() < 0)):
            found.append(f"the stamps went back {back} times")
        if self.duration < self.options.shortest:
            found.append(f"too short to be useful: {self.duration:.1f} s (at least {self.options.shortest:g} s are)")
        if zero := self.rig.get("zero", "").removeprefix("taken"):
            found.append(f"the zero is uncertain: {zero}")
        return found

    def as_metadata(self, end: End) -> dict[str, str]:
        """Return the facts as a bag's custom data."""
        of_options = {name: getattr(self.options, name) for name in ("pre_trigger", "cart_limit", "shortest")}
        motion = self.cart_motion
        rms, most = self.unevenness()
        return {
            "recorder": "cdp_ident",
            "released_at_ns": str(self.released_ns),
            "started": "by hand" if self.started_by_hand else "by release",
            "ended": end.value,
            "duration_s": f"{self.duration:.3f}",
            "samples": str(len(self.stamps)),
            "samples_lost": str(self.lost()),
            "longest_gap_s": f"{self.longest_gap():.6g}",
            "stamps_uneven_by_us": f"{1e6 * rms:.2g} rms, {1e6 * most:.2g} at most",
            "cart_at_rest": "not measured" if motion is None else str(motion <= self.options.cart_limit).lower(),
            "cart_motion_m": "" if motion is None else f"{motion:.6g}",
            "warnings": "; ".join(self.warnings()),
            ADDED: json.dumps(settings_of(self.weights)) if self.weights else "",
            "zero": self.rig.get("zero", UNKNOWN),
            RIG_NAME: self.rig.get("name", UNKNOWN),
            "rig": json.dumps(self.rig),
            "parameters": json.dumps(vars(self.options.limits) | of_options),
        }
