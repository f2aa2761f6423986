# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bytes in, stamped positions out, and what /diagnostics says of it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.bag.device_messages import Level
from cdp_ident.errors import RigError
from cdp_ident.rig.decoder import Counters
from cdp_ident.rig.joints import Calibration, Zero
from cdp_ident.rig.measurement import MeasurementStream, Totals, assess
from cdp_ident.rig.port import PortState
from cdp_ident.rig.protocol import BinaryCodec, Hello, Sample, Status

EPOCH_NS = 1_760_000_000_000_000_000
HELLO = Hello(5000, 8000, 8000, "test")
TOLD = Calibration(inner_counts_per_turn=8000, outer_counts_per_turn=8000)


class Rig:
    """Sends records to a stream, one each 5 ms, each 3 ms late."""

    def __init__(self, stream):
        self.stream, self.codec, self.now_ns = stream, BinaryCodec(), EPOCH_NS
        self.sequence, self.time_us = 0, 0

    def send(self, *records):
        return self.stream.feed(b"".join(map(self.codec.encode, records)), self.now_ns + 3_000_000)

    def samples(self, count, inner=0, status=0):
        result = []
        for _ in range(count):
            result += self.send(Sample(self.sequence, self.time_us, 0, inner, 0, status))
            self.sequence, self.time_us, self.now_ns = self.sequence + 1, self.time_us + 5000, self.now_ns + 5_000_000
        return result

    def reset(self):
        self.sequence, self.time_us = 0, 0


def test_every_sample_of_the_warm_up_is_measured_at_its_own_time():
    rig = Rig(MeasurementStream(BinaryCodec(), TOLD, None))
    measured = rig.samples(600)
    assert len(measured) == 600
    stamps = np.array([measurement.stamp_ns for measurement in measured]) - EPOCH_NS
    assert np.abs(stamps - 3_000_000 - np.arange(600) * 5_000_000).max() < 10_000
    assert measured[0].positions == (0.0, math.pi, 0.0)


def test_samples_wait_for_the_greeting_where_it_must_tell_the_counts_per_turn():
    rig = Rig(MeasurementStream(BinaryCodec(), Calibration(), None))
    assert rig.samples(400) == []
    rig.send(HELLO)
    assert len(rig.samples(1)) == 401


def test_without_a_greeting_the_wait_is_bounded_and_what_is_dropped_is_counted():
    rig = Rig(MeasurementStream(BinaryCodec(), Calibration(), None))
    rig.samples(45_000)
    dropped = rig.stream.totals().counters.dropped_without_greeting
    assert dropped >= 25_000
    rig.send(HELLO)
    assert len(rig.samples(1)) + dropped == 45_001


def test_a_reset_loses_no_sample_and_makes_the_zero_uncertain():
    rig = Rig(MeasurementStream(BinaryCodec(), TOLD, None))
    rig.samples(400)
    rig.stream.take_zero()
    assert rig.stream.totals().zero == ""
    rig.reset()
    after = rig.samples(400)
    totals = rig.stream.totals()
    assert len(after) == 400
    assert (totals.counters.device_resets, totals.counters.clock_fits_begun_anew) == (1, 1)
    assert "reset" in totals.zero
    assert np.all(np.diff([measurement.stamp_ns for measurement in after]) == pytest.approx(5_000_000, abs=20_000))


def test_the_zero_of_absolute_encoders_survives_a_reset():
    rig = Rig(MeasurementStream(BinaryCodec(), TOLD, Zero(0.0, 100.0, 0.0, 7, EPOCH_NS), survives_reset=True))
    rig.samples(300)
    rig.reset()
    assert rig.samples(300, inner=100)[-1].positions[1] == math.pi
    assert rig.stream.totals().zero == ""


@pytest.mark.parametrize(("age", "words"), [(-2.0, ""), (-4000.0, "reset")])
def test_a_kept_zero_is_doubted_when_the_device_was_reset_since(age, words):
    zero = Zero(0.0, 0.0, 0.0, round(-age * 200) if words == "" else 0, EPOCH_NS + round(age * 1e9))
    rig = Rig(MeasurementStream(BinaryCodec(), TOLD, zero))
    rig.sequence = 800 if words == "" else 0
    rig.send(HELLO)
    rig.samples(300)
    assert words in rig.stream.totals().zero
    assert (rig.stream.totals().zero == "") == (words == "")


def test_zeroing_takes_hold_at_once():
    rig = Rig(MeasurementStream(BinaryCodec(), TOLD, None))
    assert rig.samples(400, inner=50)[-1].positions[1] == pytest.approx(math.pi + math.tau * 50 / 8000)
    assert rig.stream.take_zero().counts == (0.0, 50.0, 0.0)
    assert rig.samples(1, inner=50)[-1].positions[1] == math.pi


def test_zeroing_before_any_sample_is_refused():
    with pytest.raises(RigError, match="no samples"):
        MeasurementStream(BinaryCodec(), TOLD, None).take_zero()


def test_samples_of_a_faulty_encoder_are_dropped_and_counted_and_overruns_only_counted():
    rig = Rig(MeasurementStream(BinaryCodec(), TOLD, None))
    rig.samples(300)
    assert rig.samples(5, status=Status.INNER_FAULT) == []
    assert len(rig.samples(5, status=Status.OVERRUN)) == 5
    counters = rig.stream.totals().counters
    assert (counters.encoder_faults, counters.device_overruns) == (5, 5)


def test_impossible_jumps_are_counted_also_across_a_reset():
    rig = Rig(MeasurementStream(BinaryCodec(), TOLD, None))
    for _ in range(2):
        rig.samples(300)
        assert rig.samples(2, inner=4000) == []
        rig.samples(300)
        rig.reset()
    counters = rig.stream.totals().counters
    assert (counters.impossible_jumps, counters.device_resets) == (4, 1)


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
