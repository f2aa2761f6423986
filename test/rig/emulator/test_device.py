# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated microcontroller."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.rig.decoder import Decoder, Restart
from cdp_ident.rig.emulator.device import Device, Encoders
from cdp_ident.rig.protocol import BinaryCodec, CartCommand, Hello, Sample, TextCodec


def device(rate=200.0, **options):
    return Device(BinaryCodec(), Encoders(), rate, np.random.default_rng(0), **options)


def positions(count, inner_turns=0.0):
    theta = math.pi + math.tau * inner_turns * np.arange(count)
    return np.column_stack([np.full(count, 0.02), theta, np.zeros(count)])


def decode(*frames):
    return list(Decoder(BinaryCodec()).feed(b"".join(frames)))


def test_it_greets_at_once_and_then_every_second():
    events = decode(*device().send(positions(401)))
    assert [number for number, event in enumerate(events) if isinstance(event, Hello)] == [0, 201, 402]
    assert events[0] == Hello(5000, 8000, 8000, "cdp_ident emulator 1")


def test_counters_begin_where_told_and_count_turns_and_roll_over():
    frames = device(first_count=2**31 - 2, first_time_us=2**32 - 7000).send(positions(4, 0.6 / 8000))
    samples = [event for event in decode(*frames) if isinstance(event, Sample)]
    assert [sample.inner for sample in samples] == [2**31 - 2, 2**31 - 1, 2**31 - 1, -(2**31)]
    assert [sample.time_us for sample in samples] == [4294960296, 4294965296, 3000, 8000]


def test_a_reset_starts_sequence_clock_and_counters_anew():
    rig = device(first_count=500)
    before = rig.send(positions(3, 0.1))
    rig.reset()
    after = rig.send(positions(3, 0.1))
    events = decode(*before, *after)
    assert events[4] == Hello(5000, 8000, 8000, "cdp_ident emulator 1")
    assert isinstance(events[5], Restart)
    assert events[6] == Sample(0, 0, 0, 0, 0)


def test_a_fast_clock_runs_ahead():
    (*_, last) = decode(*device(clock_error=1e-3).send(positions(1001)))
    assert isinstance(last, Sample)
    assert last.time_us == 5_005_000


CODECS = pytest.mark.parametrize("codec", [BinaryCodec(), TextCodec()], ids=lambda codec: codec.name)


def driven(codec):
    return Device(codec, Encoders(), 200.0, np.random.default_rng(0))


@CODECS
def test_of_several_commands_the_newest_holds_and_one_that_comes_again_is_none(codec):
    rig, frames = driven(codec), [codec.encode(CartCommand(number, 100 * number)) for number in range(4)]
    assert rig.receive(frames[0] + frames[1]) == pytest.approx(0.1)
    assert rig.receive(frames[1]) is None
    assert rig.receive(b"") is None
    assert rig.receive(frames[2] + frames[3][:5]) == pytest.approx(0.2)
    assert rig.receive(frames[3][5:]) == pytest.approx(0.3)


@CODECS
@given(noise=st.binary(max_size=300), place=st.integers(0, 80))
def test_a_command_behind_any_noise_is_understood_and_a_damaged_one_is_none(codec, noise, place):
    rig, frame = driven(codec), bytearray(codec.encode(CartCommand(7, -1500)))
    rig.receive(noise + codec.delimiter)
    assert rig.receive(bytes(frame)) == pytest.approx(-1.5)
    damaged = bytearray(codec.encode(CartCommand(8, 100))[:-1])
    damaged[place % len(damaged)] ^= 1
    assert rig.receive(bytes(damaged) + codec.delimiter) in (None, pytest.approx(0.1))  # a digit in lower case
