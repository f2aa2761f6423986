# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What `/diagnostics` says in which situation."""

import math
from dataclasses import replace

import pytest

from cdp_ident.rig.decoder import Counters
from cdp_ident.rig.health import Level, assess
from cdp_ident.rig.joints import Calibration
from cdp_ident.rig.measurement import Totals
from cdp_ident.rig.port import PortState
from cdp_ident.rig.protocol import Hello

OPEN = PortState("/dev/ttyACM0", "", 0)
BEFORE = Totals(
    Counters(samples=1000, published=1000),
    Hello(5000, 8000, 8000, "rig 1"),
    first_arrival_ns=10**18,
    last_arrival_ns=10**18 + 5 * 10**9,
    zero="",
)


def counted(**counters):
    return replace(BEFORE, counters=Counters(**{"samples": 1200} | counters))


NOW = counted()


def check(
    now=NOW,
    silence=0.0,
    port=OPEN,
    calibration=Calibration(),  # noqa: B008
):
    health = assess(BEFORE, now, 1.0, silence, 0.5, port, calibration)
    return health.level, health.message


def test_a_rig_that_sends_what_it_should_is_ok():
    assert check() == (Level.OK, "200 Hz")


@pytest.mark.parametrize(
    ("now", "words"),
    [
        (counted(samples=1197, lost=3), "lost: 3"),
        (counted(samples=1199, bad_checksum=1, lost=1), "bad checksum: 1"),
        (counted(device_resets=1), "resets: 1"),
        (counted(encoder_faults=4), "encoder faults: 4"),
        (counted(impossible_jumps=2), "impossible jumps: 2"),
        (counted(device_overruns=2), "overruns: 2"),
        (counted(samples=1100), "100 Hz instead of 200 Hz"),
        (replace(NOW, zero="none was ever taken"), "zero_hanging"),
    ],
)
def test_what_happened_in_the_last_second_is_a_warning(now, words):
    level, message = check(now)
    assert level is Level.WARN
    assert words in message


def test_counts_per_turn_that_contradict_the_rig_are_a_warning():
    level, message = check(calibration=Calibration(inner_counts_per_turn=4000))
    assert level is Level.WARN
    assert "inner encoder: the rig says 8000 counts per turn, the parameter 4000" in message


def test_silence_is_stale_and_no_port_an_error():
    assert check(BEFORE, silence=2.0) == (Level.STALE, "no sample for 2.0 s")
    assert check(BEFORE, silence=math.inf) == (Level.STALE, "no sample yet")
    assert check(port=PortState(None, "no port matches /dev/x", 1)) == (Level.ERROR, "no port: no port matches /dev/x")


def test_nothing_but_damaged_frames_asks_for_codec_and_baud():
    level, message = check(counted(samples=1000, malformed=70), silence=2.0)
    assert level is Level.ERROR
    assert "codec and baud" in message


def test_the_greeting_is_waited_for_some_seconds():
    level, message = check(replace(NOW, hello=None, last_arrival_ns=10**18 + 10**9))
    assert level is Level.OK
    assert "waiting for the rig's greeting" in message


def test_a_rig_without_greeting_and_parameters_is_an_error():
    level, message = check(replace(NOW, hello=None))
    assert level is Level.ERROR
    assert "counts per turn" in message
