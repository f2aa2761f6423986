# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated encoders, and the microcontroller: it reads them, writes frames, and takes commands."""

import math
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.motions import readings_of
from cdp_ident.model.time_grid import between
from cdp_ident.rig.joints import HANGING
from cdp_ident.rig.protocol import UNSIGNED_32, CartCommand, Codec, FrameError, Hello, Sample, signed_32
from cdp_ident.user_input import Limits

_LONGEST_COMMAND = 64
"""No command's frame is longer [bytes]."""
_HELLO_EVERY = 1.0
"""Time between greetings [s]."""
_LONGEST_STEP = 1e-4
"""States of encoders' own go on by steps of this at most [s], as fast as filters and elastic couplings may be."""
_AT_REST = np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
"""What the rods have of a motion, before which they were at rest."""
_LATEST = 0.1
"""So much of the past is kept for an encoder that is late [s]."""
_Counts = Annotated[int, Limits(1, 2**31)]


@dataclass(frozen=True)
class Encoders:
    """The encoders of an emulated rig."""

    metres_per_count: Annotated[float, Limits(1e-9, 1.0)] = 1e-5
    inner_counts_per_turn: _Counts = 8000
    outer_counts_per_turn: _Counts = 8000
    noise: Annotated[float, Limits(0.0, 1.0)] = 0.0
    """Standard deviation of a joint's angle before it is counted [rad]."""


class Readings:
    """What the encoders of the joints show of the motion, sample by sample."""

    def __init__(self, coefficients: Array, effects: ActingEffects, period: float) -> None:
        self._coefficients, self._period, self._now = coefficients, period, 0
        self._late_by = dict.fromkeys(JOINTS, 0.0)
        for effect, values in effects.each():
            if effect.law.lateness:
                self._late_by[effect.joint] += values[0]
        self._encoders = effects.only(lambda effect: not effect.moves and not effect.law.lateness)
        self._own = np.zeros((2, self._encoders.states - 4))
        self._past: deque[Array] = deque(maxlen=max(2, round(_LATEST / period)))

    def of(self, states: Array) -> Array:
        """Return the inner and outer encoder's angles (n, 2) [rad] of a motion's next samples (n, 7), but the cart."""
        parts = math.ceil(self._period / _LONGEST_STEP) if self._own.size else 1
        since = np.array([self._past[-1] if self._past else states[0] * _AT_REST, *states])
        at = np.arange(1, parts * len(states) + 1) / parts
        between = np.column_stack([np.interp(at, np.arange(len(since)), column) for column in since.T])
        step = self._period / parts
        begin = self._now * self._period + step
        shown = readings_of(self._coefficients, between, self._own, step, self._encoders, begin)[parts - 1 :: parts]
        for joint, delay in enumerate(self._late_by.values()):
            if delay:
                shown[:, joint] += self._late(states, delay, joint) - of_joint(states, joint)
        self._past.extend(states)
        self._now += len(states)
        return shown

    def _late(self, states: Array, delay: float, joint: int) -> Array:
        """Return a joint's angle as it was before each sample."""
        past = np.array([*self._past, *states]) if self._past else states
        stamps = np.asarray((np.arange(len(past)) - (len(past) - len(states))) * self._period, dtype=np.float64)
        time: Array = np.asarray(np.arange(len(states)) * self._period, dtype=np.float64)
        if len(past) < 2:
            return of_joint(states, joint)
        at = np.maximum(time - delay, stamps[0])
        return between(stamps, of_joint(past, joint), of_joint(past[:, 2:], joint), at)


def of_joint(values: Array, joint: int) -> Array:
    """Return what a joint has, which turns by theta1 or theta2 - theta1, of values (n, 2 or more) of both rods."""
    return values[:, 0] if joint == 0 else values[:, 1] - values[:, 0]


class Device:
    """Turns positions into the bytes that a rig's firmware would send.

    Its encoders are incremental: their counters are at `first_count` where the pendulum hangs and the cart is at 0,
    which is where it is at power-up, and after a reset they are at 0 wherever it is.
    """

    def __init__(
        self,
        codec: Codec,
        encoders: Encoders,
        rate: float,
        generator: np.random.Generator,
        first_count: int = 0,
        first_time_us: int = 0,
        clock_error: float = 0.0,
    ) -> None:
        """`rate` is in Hz; `clock_error` is by how much the device's clock is fast (1e-4: 100 ppm)."""
        self._codec = codec
        self._encoders = encoders
        self._period_us = round(1e6 / rate)
        self._clock_period_us = 1e6 / rate * (1.0 + clock_error)
        self._generator = generator
        self._time_us = float(first_time_us)
        self._sequence = 0
        self._origin: Indices | None = self._raw(np.array([HANGING]))[0] - first_count
        self._hello_due = 0
        self._unfinished = b""
        self._last_command: int | None = None

    def reset(self) -> None:
        """Start anew, as at power-up."""
        self._time_us, self._sequence, self._origin, self._hello_due = 0.0, 0, None, 0

    def send(self, positions: Array) -> list[bytes]:
        """Return the frames for positions (n, 3): cart [m], inner and outer joint [rad]; one entry a sample."""
        if self._encoders.noise:
            noise = self._generator.normal(0.0, self._encoders.noise, (len(positions), 2))
            positions = positions + np.column_stack([np.zeros(len(positions)), noise])
        counts = self._raw(positions)
        if self._origin is None:
            self._origin = counts[0]
        return [self._frames(row) for row in counts - self._origin]

    def receive(self, data: bytes) -> float | None:
        """Return the cart's acceleration [m/s^2] that the newest command in bytes from the host asks for.

        None where there is none: a damaged frame, and a command that comes again, are no command.
        """
        *frames, unfinished = (self._unfinished + data).split(self._codec.delimiter)
        self._unfinished = unfinished[-_LONGEST_COMMAND:]
        acceleration = None
        for frame in frames:
            with suppress(FrameError):
                record = self._codec.decode(frame)
                if isinstance(record, CartCommand) and record.sequence != self._last_command:
                    self._last_command, acceleration = record.sequence, 1e-3 * record.acceleration
        return acceleration

    def _raw(self, positions: Array) -> Indices:
        encoders = self._encoders
        per_radian = np.array([encoders.inner_counts_per_turn, encoders.outer_counts_per_turn]) / math.tau
        scales = np.array([1.0 / encoders.metres_per_count, *per_radian])
        return np.asarray(np.rint(positions * scales), dtype=np.int64)

    def _frames(self, counts: Indices) -> bytes:
        frames = b""
        if self._sequence >= self._hello_due:
            self._hello_due = self._sequence + round(_HELLO_EVERY * 1e6 / self._period_us)
            hello = Hello(
                self._period_us,
                self._encoders.inner_counts_per_turn,
                self._encoders.outer_counts_per_turn,
                "cdp_ident emulator 1",
            )
            frames = self._codec.encode(hello)
        cart, inner, outer = (signed_32(int(count)) for count in counts)
        sample = Sample(self._sequence & UNSIGNED_32, round(self._time_us) & UNSIGNED_32, cart, inner, outer)
        self._sequence += 1
        self._time_us += self._clock_period_us
        return frames + self._codec.encode(sample)
