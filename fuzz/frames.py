# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Serial frames on a bad line: nothing is published that was not sent, and intact samples come through."""

import math
import random

from cdp_ident.rig.decoder import Decoder, Restart
from cdp_ident.rig.protocol import BinaryCodec, Codec, Hello, Sample, TextCodec
from fuzz.campaign import FindingError
from fuzz.mutation import mutated

_SAMPLES = 60
_HELLO = Hello(5000, 8000, 8000, "rig 1.0")


def case(generator: random.Random) -> str:
    """Damage a few frames of a swing, cut the stream anywhere, and compare what is published with what was sent."""
    codec: Codec = generator.choice((BinaryCodec(), TextCodec()))
    first, begin, phase = generator.getrandbits(32), generator.getrandbits(32), generator.uniform(0, 6)
    sent = [_swing(number, first, begin, phase) for number in range(_SAMPLES)]
    frames = [codec.encode(sample) for sample in sent]
    damaged = {generator.randrange(5, _SAMPLES - 5) for _ in range(generator.randint(1, 6))}
    for number in damaged:
        frames[number] = mutated(frames[number], generator)
    frames.insert(generator.randrange(_SAMPLES), codec.encode(_HELLO))
    decoder, events, data = Decoder(codec), [], b"".join(frames)
    while data:
        size = generator.randint(1, 200)
        events += decoder.feed(data[:size])
        data = data[size:]
    published = [event for event in events if isinstance(event, Sample)]
    if not set(published) <= set(sent):
        raise FindingError(f"published but never sent: {set(published) - set(sent)}")
    if any(isinstance(event, Restart) for event in events):
        raise FindingError("a reset that was none")
    touched = damaged | {number + 1 for number in damaged}  # a damaged delimiter joins a frame to the next
    intact = {sent[number] for number in range(_SAMPLES) if number not in touched}
    if not intact <= set(published):
        raise FindingError(f"intact but not published: {len(intact - set(published))}")
    return "all intact samples" if len(published) < _SAMPLES else "all samples"


def _swing(number: int, first: int, begin: int, phase: float) -> Sample:
    t = number / 200.0
    inner, outer = 1500 * math.sin(6 * t + phase), 2500 * math.sin(11 * t + phase)
    return Sample((first + number) % 2**32, (begin + 5000 * number) % 2**32, 0, round(inner), round(outer))
