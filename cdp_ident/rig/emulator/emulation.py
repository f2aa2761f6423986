# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated rig as a whole: physics, microcontroller and cable, run at the pace of the clock on the wall."""

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np

from cdp_ident.rig.emulator.cable import SECONDS, Faults, Line, PseudoTerminal
from cdp_ident.rig.emulator.configuration import EmulatedRig
from cdp_ident.rig.emulator.device import Device, Readings
from cdp_ident.rig.emulator.motion import DrivenCart, Motion
from cdp_ident.rig.protocol import Codec
from cdp_ident.user_input import Limits

_TICK = 0.002
"""The loop wakes this often at most [s]; faster samples come in twos and more, as through USB."""
_AHEAD = 256
"""So many samples of motion are computed at once, where no command changes them."""


@dataclass(frozen=True)
class Events:
    """What happens to the emulated rig; times are since its start."""

    reset_at: Annotated[Sequence[float], SECONDS] = ()
    """The microcontroller is reset [s]."""
    unplug_at: Annotated[Sequence[float], SECONDS] = ()
    """The cable is unplugged [s]."""
    unplugged_for: Annotated[float, SECONDS] = 2.0
    """So much later it is plugged in again [s]."""
    replug_as: Path | None = None
    """Name of the port after that, if it is another one."""
    first_count: Annotated[int, Limits(-(2**31), 2**31 - 1)] = 0
    """The counters begin here (2147483000: they soon roll over)."""
    first_time: Annotated[int, Limits(0, 2**32 - 1)] = 0
    """The device's clock begins here (4290000000: it soon rolls over) [us]."""


@dataclass
class Emulation:
    """Runs an emulated rig behind the link `link` until it is stopped.

    `speed` makes the rig's time run faster than the wall's; `on_tick` is called with the rig's time [s] before the
    bytes of that time are sent.
    """

    rig: EmulatedRig
    link: Path
    codec: Codec
    generator: np.random.Generator
    faults: Faults = field(default_factory=Faults)
    events: Events = field(default_factory=Events)
    speed: float = 1.0
    on_tick: Callable[[float], None] = lambda _: None

    def __post_init__(self) -> None:
        """Make the parts, the port included. Raises `RigError` where the link cannot be made."""
        rig = self.rig
        coefficients, period = rig.coefficients(), 1.0 / rig.rate
        self._cart = DrivenCart(rig.drive) if rig.drive else None
        self._motion = Motion(coefficients, rig.script, period, rig.effects, self._cart)
        self._readings = Readings(coefficients, rig.effects, period)
        self._ahead = 1 if rig.drive else _AHEAD
        self._ready = deque(self._motion.advance(self._ahead))  # compiles, before anyone reads the port
        self._device = Device(
            self.codec,
            rig.encoders,
            rig.rate,
            self.generator,
            self.events.first_count,
            self.events.first_time,
            rig.clock_error,
        )
        self._line = Line(self.faults, self.generator)
        self._terminal: PseudoTerminal | None = PseudoTerminal(self.link)
        self._resets = deque(sorted(self.events.reset_at))
        self._unplugs = deque(sorted(self.events.unplug_at))
        self._plug_at = 0.0
        self._stop = threading.Event()
        self._sent = 0

    def stop(self) -> None:
        """Make `run` return."""
        self._stop.set()

    def run(self) -> None:
        """Run until `stop`; then unplug."""
        began = time.monotonic()
        tick = max(_TICK, 1.0 / (self.rig.rate * self.speed))
        wakes = 0
        try:
            while not self._stop.is_set():
                self._advance_to((time.monotonic() - began) * self.speed)
                wakes = max(wakes + 1, int((time.monotonic() - began) / tick))
                self._stop.wait(max(0.0, began + wakes * tick - time.monotonic()))
        finally:
            if self._terminal:
                self._terminal.unplug()

    def _advance_to(self, now: float) -> None:
        self.on_tick(now)
        while self._resets and self._resets[0] <= now:
            self._resets.popleft()
            self._device.reset()
            if self._cart:
                self._cart.forget_command()
        if self._terminal and self._unplugs and self._unplugs[0] <= now:
            self._plug_at = self._unplugs.popleft() + self.events.unplugged_for
            self._terminal.unplug()
            self._terminal = None
        elif self._terminal is None and now >= self._plug_at:
            self._terminal = PseudoTerminal(self.events.replug_as or self.link)
        due = int(now * self.rig.rate) + 1 - self._sent
        if due > 0:
            self._line.send(b"".join(self._device.send(self._next_positions(due))), now)
            self._sent += due
        arrived = self._line.receive(now)
        if arrived and self._terminal:
            self._terminal.write(arrived)
        if self._cart and self._terminal:
            commanded = self._device.receive(self._terminal.read())
            if commanded is not None:
                self._cart.command(commanded)

    def _next_positions(self, count: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        while len(self._ready) < count:
            self._ready.extend(self._motion.advance(self._ahead))
        samples = np.array([self._ready.popleft() for _ in range(count)])
        return np.column_stack([samples[:, 0], self._readings.of(samples[:, 1:])])
