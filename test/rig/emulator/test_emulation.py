# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated rig on a real pseudo-terminal, read by the real port reader and stream."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.rig.codec import BinaryCodec, Codec, TextCodec
from cdp_ident.rig.decoder import Decoder
from cdp_ident.rig.emulator.configuration import EmulatedRig
from cdp_ident.rig.emulator.drive import Drive
from cdp_ident.rig.emulator.emulation import Emulation, Events
from cdp_ident.rig.emulator.script import Wait
from cdp_ident.rig.port import PortReader
from cdp_ident.rig.records import CartCommand, Sample


def wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline, "it did not happen within 60 s"
        time.sleep(0.01)


class Reading:
    """What comes out of the emulated cable."""

    def __init__(self, link: Path, codec: Codec) -> None:
        self.decoder = Decoder(codec)
        self.samples: list[Sample] = []
        nothing = lambda _: None  # noqa: E731
        self.reader = PortReader(str(link), 115200, self.decoder.restart_stream, self.take, nothing, nothing)

    def take(self, data: bytes) -> None:
        self.samples += [event for event in self.decoder.feed(data) if isinstance(event, Sample)]


@contextmanager
def reading(link: Path, codec: Codec, rig: EmulatedRig, events: Events) -> Iterator[Reading]:
    emulation = Emulation(rig, link, codec, np.random.default_rng(3), events=events)
    thread = threading.Thread(target=emulation.run)
    result = Reading(link, codec)
    thread.start()
    result.reader.start()
    try:
        yield result
    finally:
        result.reader.stop()
        emulation.stop()
        thread.join()
    assert not link.exists()


@pytest.mark.parametrize("codec", [BinaryCodec(), TextCodec()], ids=lambda codec: codec.name)
def test_a_good_rig_is_read_without_loss(tmp_path: Path, codec: Codec) -> None:
    with reading(tmp_path / "tty", codec, EmulatedRig(), Events()) as result:
        wait_for(lambda: len(result.samples) > 400)
    assert result.decoder.counters.lost == 0
    assert np.all(np.diff([sample.time_us for sample in result.samples]) == 5000)


DRIVEN = EmulatedRig(drive=Drive(acceleration=4.0, speed=0.5, rail=0.2), script=(Wait(1000.0),))


def test_a_reset_device_brakes_until_it_is_commanded_again(tmp_path: Path) -> None:
    codec = BinaryCodec()
    with reading(tmp_path / "tty", codec, DRIVEN, Events(reset_at=[1.0])) as result:
        sequence = iter(range(1000000))

        def drive() -> bool:
            result.reader.write(codec.encode(CartCommand(next(sequence), 100)))
            return result.decoder.counters.resets > 0

        wait_for(drive)
        wait_for(lambda: len(result.samples) > 400)
    assert np.ptp([sample.cart for sample in result.samples[-50:]]) == 0
