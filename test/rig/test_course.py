# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sample that does not continue those before it is recognised."""

import math
import random

import pytest
from cobs import cobs

from cdp_ident.rig.decoder import Course, Decoder, Restart
from cdp_ident.rig.protocol import BinaryCodec, Sample, checksum


def swing(number, rate=200.0, jitter=0):
    """Return a sample of a pendulum that swings widely; 8000 counts a turn."""
    t = number / rate
    return Sample(
        number,
        round(t * 1e6) + jitter,
        0,
        round(1500 * math.sin(6 * t)),
        round(2500 * math.sin(11 * t + 1)),
    )


def course(count=50):
    result = Course()
    for number in range(count):
        result.take(swing(number))
    return result


def test_a_swing_is_foretold_also_a_few_readings_on():
    for steps in range(1, 6):
        assert course().predicts(swing(49 + steps))


@pytest.mark.parametrize(
    "change",
    [{"time_us": 2000}, {"time_us": -2000}, {"inner": 30}, {"outer": -300}, {"cart": 2**20}, {"sequence": 200}],
    ids=str,
)
def test_one_number_that_is_off_is_not(change):
    good = swing(50)
    assert not course().predicts(good._replace(**{name: getattr(good, name) + by for name, by in change.items()}))


def test_a_device_that_reads_irregularly_has_a_wider_course():
    generator, irregular = random.Random(1), Course()
    for number in range(50):
        irregular.take(swing(number, jitter=generator.randint(0, 1500)))
    assert irregular.predicts(swing(50, jitter=2000))
    assert not irregular.predicts(swing(50, jitter=500_000))


def pass_on(*samples):
    decoder = Decoder(BinaryCodec())
    return [event for sample in samples for event in decoder.feed(BinaryCodec().encode(sample))], decoder


def test_an_impulse_is_passed_on_whole():
    """A rod that is hit, or counts that slip: the samples that follow go on from there."""
    before = [swing(number) for number in range(50)]
    after = [swing(number)._replace(inner=swing(number).inner + 700) for number in range(50, 100)]
    events, decoder = pass_on(*before, *after)
    assert events == [*before, *after]
    assert (decoder.counters.device_resets, decoder.counters.lost) == (0, 0)


def test_a_device_that_paused_was_not_reset():
    before = [swing(number) for number in range(50)]
    after = [swing(number)._replace(time_us=swing(number).time_us + 900_000) for number in range(50, 100)]
    events, decoder = pass_on(*before, *after)
    assert events == [*before, *after]
    assert decoder.counters.device_resets == 0


@pytest.mark.parametrize("rate", [200.0, 1000.0])
@pytest.mark.parametrize("pause", [2e3, 5e3, 2e4], ids="{:g}us".format)
def test_a_device_that_makes_up_for_pauses_was_not_reset(rate, pause):
    generator, now, samples = random.Random(1), 0.0, []
    for number in range(10_000):
        late = generator.expovariate(1.0 / pause) if generator.random() < 0.05 else 0.0
        now = max(now + 30.0, 1e6 * number / rate + late)  # as fast as it can, until it is in time again
        samples.append(Sample(number, round(now), 0, 0, 0))
    _, decoder = pass_on(*samples)
    assert decoder.counters.device_resets == 0


def garbled(body, generator):
    """Return a frame's body with a burst, a few bytes or a few bits changed."""
    result = bytearray(body)
    kind, place = generator.randrange(3), generator.randrange(len(body))
    if kind == 0:
        result[place : place + 5] = generator.randbytes(len(result[place : place + 5]))
    for _ in range(generator.randint(2, 5) if kind == 1 else 0):
        result[generator.randrange(len(result))] = generator.randrange(256)
    for _ in range(generator.randint(4, 10) if kind == 2 else 0):
        result[generator.randrange(len(result))] ^= 1 << generator.randrange(8)
    return bytes(result)


@pytest.mark.parametrize("rate", [200.0, 1000.0])
def test_of_damaged_frames_whose_checksum_matches_hardly_any_is_published_wrong(rate):
    """A CRC-16 lets one damaged frame in 65536 through: here all of them."""
    generator, decoder = random.Random(1), Decoder(BinaryCodec())
    damaged, wrong, resets = 2000, 0, 0
    for number in range(10 * damaged):
        frame = BinaryCodec().encode(swing(number, rate))
        if number % 10 == 9:
            body = garbled(cobs.decode(frame[:-1])[:-2], generator)
            frame = cobs.encode(body + checksum(body).to_bytes(2, "little")) + b"\0"
        for event in decoder.feed(frame):
            resets += isinstance(event, Restart)
            wrong += isinstance(event, Sample) and event[:5] != swing(event.sequence, rate)[:5]
    assert wrong <= 0.005 * damaged
    assert resets <= 0.001 * damaged
