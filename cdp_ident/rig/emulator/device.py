# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated microcontroller: reads the emulated encoders, writes frames, and takes commands."""

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from cdp_ident.rig.joints import HANGING
from cdp_ident.rig.protocol import UNSIGNED_32, CartCommand, Codec, FrameError, Hello, Sample, signed_32
from cdp_ident.user_input import Limits

Array = npt.NDArray[np.float64]

_LONGEST_COMMAND = 64
"""No command's frame is longer [bytes]."""
_HELLO_EVERY = 1.0
"""Time between greetings [s]."""
_Counts = Annotated[int, Limits(1, 2**31)]


@dataclass(frozen=True)
class Encoders:
    """The encoders of an emulated rig."""

    metres_per_count: Annotated[float, Limits(1e-9, 1.0)] = 1e-5
    inner_counts_per_turn: _Counts = 8000
    outer_counts_per_turn: _Counts = 8000
    noise: Annotated[float, Limits(0.0, 1.0)] = 0.0
    """Standard deviation of a joint's angle before it is counted [rad]."""


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
        self._origin: npt.NDArray[np.int64] | None = self._raw(np.array([HANGING]))[0] - first_count
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

    def _raw(self, positions: Array) -> npt.NDArray[np.int64]:
        encoders = self._encoders
        per_radian = np.array([encoders.inner_counts_per_turn, encoders.outer_counts_per_turn]) / math.tau
        scales = np.array([1.0 / encoders.metres_per_count, *per_radian])
        return np.asarray(np.rint(positions * scales), dtype=np.int64)

    def _frames(self, counts: npt.NDArray[np.int64]) -> bytes:
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
