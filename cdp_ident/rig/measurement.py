# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a serial port's bytes to stamped joint positions: everything of the driver but the port and ROS."""

import threading
from dataclasses import dataclass, replace
from typing import NamedTuple

from cdp_ident.bag.diagnostics import ClockRate
from cdp_ident.errors import RigError
from cdp_ident.rig.decoder import Counters, Decoder, Restart
from cdp_ident.rig.device_clock import DeviceClock
from cdp_ident.rig.joints import Calibration, JointTracker, Triple, Zero
from cdp_ident.rig.protocol import ENCODER_FAULTS, Codec, Hello, Sample, Status

_MOST_WAITING = 20_000
"""Samples that wait for the clock's warm-up or the greeting at most; older ones are dropped."""


class Measurement(NamedTuple):
    """The pendulum's position at one instant."""

    stamp_ns: int
    """Host's time of the measurement [ns]."""
    device_ns: int
    """The device's own time of it, roll-overs counted [ns]."""
    positions: Triple
    """Cart [m], inner joint [rad], outer joint relative to the inner rod [rad]; zero upright."""


@dataclass
class Totals:
    """What has happened since the start."""

    counters: Counters
    hello: Hello | None = None
    first_arrival_ns: int | None = None
    """When the first verified sample arrived (host's time) …"""
    last_arrival_ns: int | None = None
    """… and when the last one did."""
    clock_rate: ClockRate | None = None
    """How fast the device's clock runs, None while it is not known."""
    zero: str = "none was ever taken"
    """What is wrong with the zero, in words; empty if nothing is."""
    zero_counts: Triple = (0.0, 0.0, 0.0)
    """The counts that are taken as hanging: cart, inner, outer."""


class MeasurementStream:
    """Turns bytes into measurements. Samples wait while the clock warms up after a start or reset; none is lost by it.

    One thread feeds it; any thread may ask for totals and take a zero.
    """

    def __init__(
        self,
        codec: Codec,
        calibration: Calibration,
        zero: Zero | None,
        survives_reset: bool = False,
        simulated: bool = False,
    ) -> None:
        """`survives_reset` is for absolute encoders, whose counts mean the same after the device was reset.

        `simulated` says that the host's time is simulated; see `DeviceClock`.
        """
        self._simulated, self._survives_reset = simulated, survives_reset
        self._decoder = Decoder(codec)
        self._calibration, self._needs_greeting = calibration, calibration.needs_greeting()
        self._counters = self._decoder.counters
        self._totals = Totals(self._counters)
        if zero:
            self._totals.zero, self._totals.zero_counts = "", zero.counts
        self._unchecked_zero = None if survives_reset else zero
        """A kept zero, while it is not known whether the device was reset since."""
        self._lock = threading.Lock()
        self._clock = DeviceClock(simulated)
        self._tracker: JointTracker | None = None
        self._waiting: list[Sample] = []
        self._last: tuple[Sample, int] | None = None

    def port_was_opened(self) -> None:
        """Discard the unfinished frame of the previous connection."""
        with self._lock:
            self._decoder.restart_stream()

    def feed(self, data: bytes, arrival_ns: int) -> list[Measurement]:
        """Take bytes that arrived at `arrival_ns` (host's time) or before; return the measurements they complete."""
        with self._lock:
            result: list[Measurement] = []
            for event in self._decoder.feed(data):
                if isinstance(event, Hello):
                    self._totals.hello, self._needs_greeting = event, False
                elif isinstance(event, Restart):
                    result += self._begin_anew()
                    self._tracker = None
                    if not self._survives_reset:
                        self._doubt_zero()
                else:
                    result += self._take(event, arrival_ns)
            self._counters.published += len(result)
            return result

    def totals(self) -> Totals:
        """Return a copy of what has happened since the start."""
        with self._lock:
            return replace(self._totals, counters=replace(self._counters), clock_rate=self._clock.rate())

    def take_zero(self) -> Zero:
        """Take the last second as hanging, from now on, and return it to be kept. Raises `RigError` while it moves."""
        with self._lock:
            if self._tracker is None or self._last is None:
                raise RigError("no samples have come: check the port in /diagnostics")
            counts = self._tracker.resting_counts()
            sample, stamp = self._last
            self._tracker.zero = counts
            self._totals.zero, self._totals.zero_counts, self._unchecked_zero = "", counts, None
            return Zero(*counts, sample.sequence, stamp)

    def _doubt_zero(self) -> None:
        self._totals.zero, self._unchecked_zero = "the device was reset since it was taken", None

    def _take(self, sample: Sample, arrival_ns: int) -> list[Measurement]:
        result: list[Measurement] = []
        self._totals.first_arrival_ns = self._totals.first_arrival_ns or arrival_ns
        self._totals.last_arrival_ns = arrival_ns
        if self._clock.is_new_run(sample.time_us, arrival_ns):
            result += self._begin_anew()
        self._clock.observe(sample.time_us, arrival_ns)
        self._waiting.append(sample)
        if self._clock.ready and not self._needs_greeting:
            result += self._stamp_waiting()
        elif len(self._waiting) > _MOST_WAITING:
            self._counters.dropped_without_greeting += len(self._waiting) // 2
            del self._waiting[: len(self._waiting) // 2]
        return result

    def _begin_anew(self) -> list[Measurement]:
        """Send what waits, and begin the clock's mapping anew."""
        result = self._stamp_waiting()
        self._clock = DeviceClock(self._simulated)
        self._counters.clock_fits_begun_anew += 1
        return result

    def _stamp_waiting(self) -> list[Measurement]:
        waiting, self._waiting = self._waiting, []
        if self._needs_greeting:
            self._counters.dropped_without_greeting += len(waiting)
            return []
        result = []
        for sample in waiting:
            stamp, device = self._clock.times(sample.time_us)
            positions = self._positions(sample, stamp)
            if positions is not None:
                result.append(Measurement(stamp, device, positions))
        return result

    def _positions(self, sample: Sample, stamp: int) -> Triple | None:
        if self._unchecked_zero and self._totals.hello:
            zero, self._unchecked_zero = self._unchecked_zero, None
            if not zero.is_of_this_run(sample.sequence, stamp, self._totals.hello.period_us):
                self._doubt_zero()
        self._last = (sample, stamp)
        if sample.status:  # rarely: to ask for flags takes as long as all else here
            self._counters.device_overruns += bool(sample.status & Status.OVERRUN)
            if sample.status & ENCODER_FAULTS:
                self._counters.encoder_faults += 1
                return None
        if self._tracker is None:
            scales = self._calibration.scales(self._totals.hello)
            self._tracker = JointTracker(scales, self._calibration, self._totals.zero_counts)
        positions = self._tracker.positions(sample)
        self._counters.impossible_jumps += positions is None
        return positions
