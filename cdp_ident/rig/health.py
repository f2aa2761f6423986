# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the rig is doing, in the levels and words of `/diagnostics`."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

from cdp_ident.bag.diagnostics import CLOCK_RATE, CLOCK_RATE_STD
from cdp_ident.rig.joints import Calibration
from cdp_ident.rig.measurement import Totals
from cdp_ident.rig.port import PortState

_GREETING_WITHIN_NS = 3_000_000_000
"""A rig greets about once a second: after so long [ns] without, it does not greet."""
_PROBLEMS = ("lost", "bad_checksum", "device_resets", "device_overruns", "encoder_faults", "impossible_jumps")
"""Counters that should stand still."""


class Level(IntEnum):
    """Levels of a diagnostic status, as REP 107 has them."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Health:
    """What a node reports of itself."""

    level: Level
    message: str
    values: Mapping[str, str]
    hardware_id: str = ""
    """Which device it is about, if any."""


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
