# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The decoder against whatever can come out of a cable."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cdp_ident.rig.decoder import LONGEST_FRAME, Counters, Decoder, Restart
from cdp_ident.rig.protocol import BinaryCodec, CartCommand, Hello, Sample, TextCodec, signed_32

CODECS = [BinaryCodec(), TextCodec()]
both = pytest.mark.parametrize("codec", CODECS, ids=lambda codec: codec.name)
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


@both
def test_a_command_that_comes_back_is_no_frame_of_a_rig(codec):
    decoder = Decoder(codec)
    assert decoder.feed(stream(codec, HELLO, CartCommand(1, 5))) == [HELLO]
    assert decoder.counters.malformed == 1


@both
@given(seed=st.integers(), first=st.integers(0, 2**32 - 1), time_us=st.integers(0, 2**32 - 1))
def test_an_intact_stream_comes_through_whole_however_it_is_cut(codec, seed, first, time_us):
    decoder = Decoder(codec)
    sent = run(first, 50, time_us)
    data = stream(codec, HELLO, *sent, HELLO)
    assert feed_in_pieces(decoder, data, random.Random(seed)) == [HELLO, *sent, HELLO]
    assert decoder.counters == Counters(samples=50)


@both
@given(pieces=st.lists(st.binary(max_size=400)))
def test_arbitrary_bytes_never_raise_and_an_intact_stream_after_them_comes_through(codec, pieces):
    decoder = Decoder(codec)
    for piece in pieces:
        decoder.feed(piece)
    sent = run()
    events = decoder.feed(codec.delimiter + stream(codec, *sent))
    assert events[-50:] == sent


@both
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


@both
def test_a_flipped_bit_is_counted_as_bad_checksum_and_as_one_lost(codec):
    sent = run()
    frames = [codec.encode(sample) for sample in sent]
    right, wrong = (b"25000", b"25001") if codec.name == "text" else (b"\xa8\x61", b"\xa9\x61")  # the time
    assert right in frames[20]
    frames[20] = frames[20].replace(right, wrong)
    decoder = Decoder(codec)
    assert decoder.feed(b"".join(frames)) == sent[:20] + sent[21:]
    assert (decoder.counters.bad_checksum, decoder.counters.lost, decoder.counters.malformed) == (1, 1, 0)


@both
def test_bytes_without_a_delimiter_are_not_hoarded(codec):
    decoder = Decoder(codec)
    decoder.feed(codec.delimiter)
    for _ in range(1000):
        decoder.feed(b"\x55" * 100)
        assert len(decoder._rest) <= LONGEST_FRAME
    sent = run()
    assert decoder.feed(codec.delimiter + stream(codec, *sent)) == sent
    assert decoder.counters.malformed > 100000 // (LONGEST_FRAME + 100)


@both
def test_joining_a_running_stream_in_the_middle_of_a_frame_is_no_error(codec):
    sent = run()
    decoder = Decoder(codec)
    assert decoder.feed(stream(codec, *sent)[9:]) == sent[1:]
    assert (decoder.counters.malformed, decoder.counters.bad_checksum) == (0, 0)


@both
def test_lost_and_repeated_samples_are_counted(codec):
    sent = run()
    decoder = Decoder(codec)
    arrived = [sent[0], sent[0], *sent[1:10], sent[5], sent[9], *sent[15:50]]
    assert decoder.feed(stream(codec, *arrived)) == [*sent[:10], *sent[15:]]
    assert (decoder.counters.lost, decoder.counters.duplicates, decoder.counters.device_resets) == (5, 3, 0)


@both
@pytest.mark.parametrize(("first", "time_us"), [(0, 3000), (7, 3000), (2**31, 2**31), (2**32 - 60, 2**32 - 9000)])
def test_a_reset_is_told_once_and_loses_nothing(codec, first, time_us):
    before, after = run(first, 50, time_us), run(0, 50, 2000)
    decoder = Decoder(codec)
    assert decoder.feed(stream(codec, *before, *after)) == [*before, Restart(), *after]
    assert (decoder.counters.device_resets, decoder.counters.lost, decoder.counters.samples) == (1, 0, 100)


@both
def test_one_sample_that_claims_an_impossible_jump_is_no_reset(codec):
    sent = run()
    liar = Sample(3_000_000_000, 17, 0, 0, 0)
    decoder = Decoder(codec)
    assert decoder.feed(stream(codec, *sent[:20], liar, *sent[21:])) == sent[:20] + sent[21:]
    assert (decoder.counters.device_resets, decoder.counters.lost) == (0, 1)


@both
def test_counters_and_sequence_go_on_where_they_were_after_the_port_was_opened_anew(codec):
    sent = run()
    decoder = Decoder(codec)
    events = decoder.feed(stream(codec, *sent[:20])[:-4])
    decoder.restart_stream()
    events += decoder.feed(stream(codec, *sent[25:]))
    assert events == sent[:19] + sent[25:]
    assert (decoder.counters.lost, decoder.counters.malformed) == (6, 0)
