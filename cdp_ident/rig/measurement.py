# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a serial port's bytes to stamped joint positions, and how that goes: all of the driver but the port and ROS."""

import math
import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from cdp_ident.bag.device_messages import CLOCK_RATE, CLOCK_RATE_STD, ClockRate, Health, Level
from cdp_ident.errors import RigError
from cdp_ident.rig.decoder import Counters, Decoder, Event, Restart
from cdp_ident.rig.device_clock import DeviceClock
from cdp_ident.rig.joints import Calibration, JointTracker, Triple, Zero
from cdp_ident.rig.port import PortState
from cdp_ident.rig.protocol import ENCODER_FAULTS, Codec, Hello, Sample, Status

_MOST_WAITING = 20_000
"""Samples that wait for the clock's warm-up or the greeting at most; older ones are dropped."""
_GREETING_WITHIN_NS = 3_000_000_000
"""A rig greets about once a second: after so long [ns] without, it does not greet."""
_PROBLEMS = ("lost", "bad_checksum", "device_resets", "device_overruns", "encoder_faults", "impossible_jumps")
"""Counters that should stand still."""


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
            result = [made for event in self._decoder.feed(data) for made in self._take(event, arrival_ns)]
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

    def _take(self, event: Event, arrival_ns: int) -> Iterator[Measurement]:
        """Take what came; yield the measurements that it completes."""
        if isinstance(event, Hello):
            self._totals.hello, self._needs_greeting = event, False
            return
        if isinstance(event, Restart):
            yield from self._begin_anew()
            self._tracker = None
            if not self._survives_reset:
                self._doubt_zero()
            return
        self._totals.first_arrival_ns = self._totals.first_arrival_ns or arrival_ns
        self._totals.last_arrival_ns = arrival_ns
        if self._clock.is_new_run(event.time_us, arrival_ns):
            yield from self._begin_anew()
        self._clock.observe(event.time_us, arrival_ns)
        self._waiting.append(event)
        if self._clock.ready and not self._needs_greeting:
            yield from self._stamp_waiting()
        elif len(self._waiting) > _MOST_WAITING:
            self._counters.dropped_without_greeting += len(self._waiting) // 2
            del self._waiting[: len(self._waiting) // 2]

    def _begin_anew(self) -> Iterator[Measurement]:
        """Send what waits, and begin the clock's mapping anew."""
        yield from self._stamp_waiting()
        self._clock = DeviceClock(self._simulated)
        self._counters.clock_fits_begun_anew += 1

    def _stamp_waiting(self) -> Iterator[Measurement]:
        waiting, self._waiting = self._waiting, []
        if self._needs_greeting:
            self._counters.dropped_without_greeting += len(waiting)
            return
        for sample in waiting:
            stamp, device = self._clock.times(sample.time_us)
            if positions := self._positions(sample, stamp):
                yield Measurement(stamp, device, positions)

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


def assess(
    before: Totals,
    now: Totals,
    seconds: float,
    silence: float,
    stale_after: float,
    port: PortState,
    calibration: Calibration,
) -> Health:
    """Assess the time since the totals `before`, which were taken `seconds` ago.

    `silence` is the time since the last verified sample [s], `stale_after` its limit, `calibration` the user's
    parameters of the encoders.
    """
    since = {name: count - getattr(before.counters, name) for name, count in vars(now.counters).items()}
    rate = since["samples"] / seconds if seconds > 0 else 0.0
    expected = 1e6 / now.hello.period_us if now.hello else None
    values = {
        "port": port.name or "none",
        "port state": "open" if port.name else port.problem,
        "times unplugged": str(port.unplugged),
        "firmware": now.hello.firmware if now.hello else "unknown",
        "rate [Hz]": f"{rate:.1f}",
        "expected rate [Hz]": f"{expected:.1f}" if expected else "unknown",
        **{_in_words(name): str(count) for name, count in vars(now.counters).items()},
        CLOCK_RATE: f"{1e6 * now.clock_rate.fast:.3f}" if now.clock_rate else "unknown",
        CLOCK_RATE_STD: f"{1e6 * now.clock_rate.std:.3f}" if now.clock_rate else "unknown",
        "zero": now.zero or "taken",
        "zero counts": ", ".join(f"{count:g}" for count in now.zero_counts),
        "counts per turn": ", ".join(str(counts or "unknown") for counts in calibration.counts_per_turn(now.hello)),
        "metres per count": f"{calibration.metres_per_count:g}",
        "signs": ", ".join(str(sign) for sign in calibration.signs),
    }
    device = " on ".join(filter(None, (now.hello and now.hello.firmware, port.name)))

    def health(level: Level, message: str) -> Health:
        return Health(level, message, values, device)

    if port.name is None:
        return health(Level.ERROR, f"no port: {port.problem}")
    if silence > stale_after:
        if damaged := since["bad_checksum"] + since["malformed"]:
            return health(
                Level.ERROR, f"bytes came but no intact frame (damaged: {damaged}): are codec and baud right?"
            )
        return health(Level.STALE, f"no sample for {silence:.1f} s" if math.isfinite(silence) else "no sample yet")
    if calibration.needs_greeting() and now.hello is None:
        if (now.last_arrival_ns or 0) - (now.first_arrival_ns or 0) < _GREETING_WITHIN_NS:
            return health(Level.OK, "waiting for the rig's greeting, which gives the counts per turn")
        return health(Level.ERROR, "nothing is published: no greeting gave the counts per turn; set them as parameters")
    problems = [f"{_in_words(name)}: {since[name]}" for name in _PROBLEMS if since[name]]
    if expected and before.counters.samples and rate < 0.95 * expected and not since["lost"]:
        problems.append(f"{rate:.0f} Hz instead of {expected:.0f} Hz")
    if now.hello:
        for joint, said, count in (
            ("inner", calibration.inner_counts_per_turn, now.hello.inner_counts),
            ("outer", calibration.outer_counts_per_turn, now.hello.outer_counts),
        ):
            if said and said != count:
                problems.append(f"{joint} encoder: the rig says {count} counts per turn, the parameter {said}")
    if now.zero:
        problems.append(f"zero: {now.zero}; let it hang and call ~/zero_hanging")
    if problems:
        return health(Level.WARN, "; ".join(problems))
    return health(Level.OK, f"{rate:.0f} Hz")


def _in_words(counter: str) -> str:
    return counter.replace("_", " ")
