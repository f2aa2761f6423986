# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The decoder against whatever can come out of a cable, and samples that do not continue those before them."""

import math
import random

import pytest
from cobs import cobs
from hypothesis import given, settings
from hypothesis import strategies as st

from cdp_ident.rig.decoder import LONGEST_FRAME, Counters, Course, Decoder, Restart
from cdp_ident.rig.protocol import BinaryCodec, CartCommand, Hello, Sample, checksum, signed_32

HELLO = Hello(1000, 8000, 8000, "rig 1.0")


def run(first=0, count=50, time_us=5000):
    """Return what a device sends from a sequence number and a time on."""
    numbers = range(first, first + count)
    return [
        Sample(number % 2**32, (time_us + 1000 * step) % 2**32, signed_32(7 * number), signed_32(-5 * number), 3 * step)
        for step, number in enumerate(numbers)
    ]


def stream(codec, *records):
    return b"".join(codec.encode(record) for record in records)


def feed_in_pieces(decoder, data, generator):
    events = []
    while data:
        size = generator.randint(1, 90)
        events += decoder.feed(data[:size])
        data = data[size:]
    return events


def test_a_command_that_comes_back_is_no_frame_of_a_rig(codec):
    decoder = Decoder(codec)
    assert decoder.feed(stream(codec, HELLO, CartCommand(1, 5))) == [HELLO]
    assert decoder.counters.malformed == 1


@given(seed=st.integers(), first=st.integers(0, 2**32 - 1), time_us=st.integers(0, 2**32 - 1))
def test_an_intact_stream_comes_through_whole_however_it_is_cut(codec, seed, first, time_us):
    decoder = Decoder(codec)
    sent = run(first, 50, time_us)
    data = stream(codec, HELLO, *sent, HELLO)
    assert feed_in_pieces(decoder, data, random.Random(seed)) == [HELLO, *sent, HELLO]
    assert decoder.counters == Counters(samples=50)


@given(pieces=st.lists(st.binary(max_size=400)))
def test_arbitrary_bytes_never_raise_and_an_intact_stream_after_them_comes_through(codec, pieces):
    decoder = Decoder(codec)
    for piece in pieces:
        decoder.feed(piece)
    sent = run()
    events = decoder.feed(codec.delimiter + stream(codec, *sent))
    assert events[-50:] == sent


@settings(derandomize=True)  # one damaged frame in 65536 passes a CRC-16: a fixed choice of cases keeps to the others
@given(data=st.data())
def test_flips_cuts_and_insertions_lose_only_what_they_touch(codec, data):
    sent = run()
    frames = [codec.encode(sample) for sample in sent]
    damaged = data.draw(st.sets(st.integers(2, 47), max_size=6))
    for number in damaged:
        frame = bytearray(frames[number])
        place = data.draw(st.integers(0, len(frame) - 1))
        kind = data.draw(st.sampled_from(["flip", "cut", "insert", "burst"]))
        if kind == "flip":
            frame[place] ^= 1 << data.draw(st.integers(0, 7))
        elif kind == "cut":
            del frame[place : place + data.draw(st.integers(1, 5))]
        elif kind == "insert":
            frame[place:place] = data.draw(st.binary(min_size=1, max_size=5))
        else:
            frame[place:] = data.draw(st.binary(min_size=20, max_size=300))
        frames[number] = bytes(frame)
    decoder = Decoder(codec)
    events = feed_in_pieces(decoder, b"".join(frames), random.Random(len(damaged)))
    touched = damaged | {number + 1 for number in damaged}  # a damaged delimiter joins a frame to the next
    assert set(events) <= set(sent)
    assert {sent[number] for number in range(50) if number not in touched} <= set(events)
    assert decoder.counters.lost == 50 - len(events)
    assert decoder.counters.device_resets == 0


def test_a_flipped_bit_is_counted_as_bad_checksum_and_as_one_lost(codec):
    sent = run()
    frames = [codec.encode(sample) for sample in sent]
    right, wrong = (b"25000", b"25001") if codec.name == "text" else (b"\xa8\x61", b"\xa9\x61")  # the time
    assert right in frames[20]
    frames[20] = frames[20].replace(right, wrong)
    decoder = Decoder(codec)
    assert decoder.feed(b"".join(frames)) == sent[:20] + sent[21:]
    assert (decoder.counters.bad_checksum, decoder.counters.lost, decoder.counters.malformed) == (1, 1, 0)


def test_bytes_without_a_delimiter_are_not_hoarded(codec):
    decoder = Decoder(codec)
    decoder.feed(codec.delimiter)
    for _ in range(1000):
        decoder.feed(b"\x55" * 100)
        assert len(decoder._rest) <= LONGEST_FRAME
    sent = run()
    assert decoder.feed(codec.delimiter + stream(codec, *sent)) == sent
    assert decoder.counters.malformed > 100000 // (LONGEST_FRAME + 100)


def test_joining_a_running_stream_in_the_middle_of_a_frame_is_no_error(codec):
    sent = run()
    decoder = Decoder(codec)
    assert decoder.feed(stream(codec, *sent)[9:]) == sent[1:]
    assert (decoder.counters.malformed, decoder.counters.bad_checksum) == (0, 0)


def test_lost_and_repeated_samples_are_counted(codec):
    sent = run()
    decoder = Decoder(codec)
    arrived = [sent[0], sent[0], *sent[1:10], sent[5], sent[9], *sent[15:50]]
    assert decoder.feed(stream(codec, *arrived)) == [*sent[:10], *sent[15:]]
    assert (decoder.counters.lost, decoder.counters.duplicates, decoder.counters.device_resets) == (5, 3, 0)


@pytest.mark.parametrize(("first", "time_us"), [(0, 3000), (7, 3000), (2**31, 2**31), (2**32 - 60, 2**32 - 9000)])
def test_a_reset_is_told_once_and_loses_nothing(codec, first, time_us):
    before, after = run(first, 50, time_us), run(0, 50, 2000)
    decoder = Decoder(codec)
    assert decoder.feed(stream(codec, *before, *after)) == [*before, Restart(), *after]
    assert (decoder.counters.device_resets, decoder.counters.lost, decoder.counters.samples) == (1, 0, 100)


def test_one_sample_that_claims_an_impossible_jump_is_no_reset(codec):
    sent = run()
    liar = Sample(3_000_000_000, 17, 0, 0, 0)
    decoder = Decoder(codec)
    assert decoder.feed(stream(codec, *sent[:20], liar, *sent[21:])) == sent[:20] + sent[21:]
    assert (decoder.counters.device_resets, decoder.counters.lost) == (0, 1)


def test_counters_and_sequence_go_on_where_they_were_after_the_port_was_opened_anew(codec):
    sent = run()
    decoder = Decoder(codec)
    events = decoder.feed(stream(codec, *sent[:20])[:-4])
    decoder.restart_stream()
    events += decoder.feed(stream(codec, *sent[25:]))
    assert events == sent[:19] + sent[25:]
    assert (decoder.counters.lost, decoder.counters.malformed) == (6, 0)


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
