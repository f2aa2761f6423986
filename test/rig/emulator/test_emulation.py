"""The emulated rig on a real pseudo-terminal, read by the real port reader and stream."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.errors import RigError
from cdp_ident.rig.codec import BinaryCodec, Codec, TextCodec
from cdp_ident.rig.decoder import Decoder, Event, Restart
from cdp_ident.rig.emulator.configuration import EmulatedRig
from cdp_ident.rig.emulator.drive import Drive
from cdp_ident.rig.emulator.emulation import Emulation, Events
from cdp_ident.rig.emulator.faults import Faults
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

    def __init__(self, pattern: Path, codec: Codec) -> None:
        self.decoder = Decoder(codec)
        self.events: list[Event] = []
        self.reader = PortReader(
            str(pattern), 115200, self.decoder.restart_stream, self.take, lambda _: None, lambda _: None
        )

    def take(self, data: bytes) -> None:
        self.events += self.decoder.feed(data)

    @property
    def samples(self) -> list[Sample]:
        return [event for event in self.events if isinstance(event, Sample)]


@contextmanager
def reading(
    pattern: Path,
    link: Path,
    codec: Codec,
    faults: Faults = Faults(),  # noqa: B008
    rig: EmulatedRig = EmulatedRig(),  # noqa: B008
    **events: object,
) -> Iterator[Reading]:
    emulation = Emulation(
        rig,
        link,
        codec,
        np.random.default_rng(3),
        faults,
        Events(**events),  # type: ignore[arg-type]
    )
    thread = threading.Thread(target=emulation.run)
    result = Reading(pattern, codec)
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
    with reading(tmp_path / "tty", tmp_path / "tty", codec) as result:
        wait_for(lambda: len(result.samples) > 400)
    assert result.decoder.counters.lost == 0
    assert np.all(np.diff([sample.time_us for sample in result.samples]) == 5000)


@pytest.mark.parametrize("codec", [BinaryCodec(), TextCodec()], ids=lambda codec: codec.name)
def test_flips_losses_and_bursts_are_counted_and_only_sent_samples_come_through(tmp_path: Path, codec: Codec) -> None:
    with reading(tmp_path / "tty", tmp_path / "tty", codec, Faults(flips=2e-3, losses=1e-3, bursts=2.0)) as result:
        wait_for(lambda: len(result.samples) > 300)
    counters = result.decoder.counters
    assert counters.lost > 0
    assert counters.bad_checksum + counters.malformed > 0
    assert all(sample.time_us == sample.sequence * 5000 for sample in result.samples)
    assert counters.resets == 0


def test_a_reset_and_rolling_over_clock_and_counters_are_noticed(tmp_path: Path) -> None:
    with reading(
        tmp_path / "tty",
        tmp_path / "tty",
        BinaryCodec(),
        first_count=2**31 - 1,
        first_time_us=2**32 - 500_000,
        resets=[1.5],
    ) as result:
        wait_for(lambda: result.decoder.counters.resets == 1)
    place = next(number for number, event in enumerate(result.events) if isinstance(event, Restart))
    before = [event for event in result.events[:place] if isinstance(event, Sample)]
    assert before[-1].time_us < 2_000_000  # it rolled over
    assert before[0].inner == 2**31 - 1
    assert result.decoder.counters.lost == 0
    assert result.samples[len(before)].sequence == 0


def test_unplugged_it_comes_back_under_another_name(tmp_path: Path) -> None:
    with reading(
        tmp_path / "tty*",
        tmp_path / "tty0",
        BinaryCodec(),
        unplugs=[0.5],
        unplugged_for=0.3,
        replug_as=tmp_path / "tty1",
    ) as result:
        wait_for(lambda: result.reader.port.unplugged == 1 and result.reader.port.name == str(tmp_path / "tty1"))
        seen = len(result.samples)
        wait_for(lambda: len(result.samples) > seen + 20)
    assert result.decoder.counters.resets == 0
    assert result.decoder.counters.lost > 20


def test_a_stall_loses_nothing(tmp_path: Path) -> None:
    with reading(
        tmp_path / "tty", tmp_path / "tty", BinaryCodec(), Faults(stall_every=1.0, stall_for=0.4, delay=0.015)
    ) as result:
        wait_for(lambda: len(result.samples) > 500)
    assert result.decoder.counters.lost == 0


def test_a_link_never_takes_the_place_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "tty").write_text("mine")
    with pytest.raises(RigError, match="no link"):
        Emulation(EmulatedRig(), tmp_path / "tty", BinaryCodec(), np.random.default_rng(0))
    assert (tmp_path / "tty").read_text() == "mine"


DRIVEN = EmulatedRig(drive=Drive(acceleration=4.0, speed=0.5, rail=0.2), script=(Wait(1000.0),))


@pytest.mark.parametrize("codec", [BinaryCodec(), TextCodec()], ids=lambda codec: codec.name)
def test_a_commanded_cart_moves_stops_with_the_commands_and_never_leaves_its_rail(tmp_path: Path, codec: Codec) -> None:
    link = tmp_path / "tty"
    with reading(link, link, codec, rig=DRIVEN) as result:
        wait_for(lambda: len(result.samples) > 10)
        sequence = 0

        def cart() -> float:
            return result.samples[-1].cart * DRIVEN.encoders.metres_per_count

        def command(acceleration: int) -> None:
            nonlocal sequence
            sequence += 1
            result.reader.write(codec.encode(CartCommand(sequence, acceleration)))

        def drive(acceleration: int) -> bool:
            command(acceleration)
            return abs(cart()) > 0.195

        wait_for(lambda: drive(1000))  # at the rail's end, and kept there
        for _ in range(20):
            assert drive(1000)
            time.sleep(0.01)
        wait_for(lambda: not drive(-500))
        rest = len(result.samples)
        result.reader.write(codec.encode(CartCommand(sequence, 500)) * 5)  # what comes again is no command
        result.reader.write(b"damaged" + codec.encode(CartCommand(sequence + 1, 500))[1:])
        wait_for(lambda: len(result.samples) > rest + 150)
    positions = np.array([sample.cart for sample in result.samples]) * DRIVEN.encoders.metres_per_count
    assert np.abs(positions).max() < 0.2 + 1e-5
    assert np.abs(np.diff(positions)).max() < 0.5 / DRIVEN.rate + 2e-5
    assert np.ptp(positions[-50:]) == 0.0
    inner = np.array([sample.inner for sample in result.samples])
    assert np.ptp(inner) > 100  # it swings


def test_a_reset_device_brakes_until_it_is_commanded_again(tmp_path: Path) -> None:
    link, codec = tmp_path / "tty", BinaryCodec()
    with reading(link, link, codec, rig=DRIVEN, resets=[1.0]) as result:
        sequence = iter(range(1000000))

        def drive() -> bool:
            result.reader.write(codec.encode(CartCommand(next(sequence), 100)))
            return result.decoder.counters.resets > 0

        wait_for(drive)
        wait_for(lambda: len(result.samples) > 400)
    assert np.ptp([sample.cart for sample in result.samples[-50:]]) == 0
