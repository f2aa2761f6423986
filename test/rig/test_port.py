# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The port's reader on real pseudo-terminals."""

import fcntl
import os
import struct
import termios
import time
import tty
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import serial

from cdp_ident.rig.port import PortReader

TIOCGEXCL = 0x80045440
"""Of Linux; Python has no name for it."""


def wait_for(condition):
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline, "it did not happen within 30 s"
        time.sleep(0.01)


def is_taken(terminal):
    """Return whether a program has a terminal to itself."""
    return bool(struct.unpack("i", fcntl.ioctl(terminal, TIOCGEXCL, bytes(4)))[0])


class Cable:
    """A pseudo-terminal behind a link."""

    def __init__(self, link):
        self.link = link
        self.device, self.computer = os.openpty()
        tty.setraw(self.computer)
        link.symlink_to(os.ttyname(self.computer))

    def unplug(self):
        self.link.unlink()
        os.close(self.device)
        os.close(self.computer)


class Listener:
    def __init__(self, pattern, baud=115200, reset_on_open=False):
        self.data, self.said, self.opened = b"", [""], 0
        self.arrivals = []
        said = self.said.append
        self.reader = PortReader(pattern, baud, self.on_open, self.on_bytes, said, said, reset_on_open)
        self.reader.start()

    def on_open(self):
        self.opened += 1

    def on_bytes(self, data):
        self.arrivals.append(time.monotonic())
        self.data += data


@pytest.fixture
def listen():
    listeners = []

    def start(pattern, **options):
        listeners.append(Listener(str(pattern), **options))
        return listeners[-1]

    yield start
    for listener in listeners:
        listener.reader.stop()


@pytest.fixture
def connected(tmp_path, listen):
    """A cable, and who listens to it."""
    cable = Cable(tmp_path / "tty")
    listener = listen(cable.link)
    wait_for(lambda: listener.opened == 1)
    return cable, listener


def test_bytes_come_through_in_order(connected):
    cable, listener = connected
    sent = b""
    for number in range(200):
        sent += (piece := bytes([number]) * (number % 7))
        os.write(cable.device, piece)
    wait_for(lambda: len(listener.data) >= len(sent))
    assert listener.data == sent
    assert listener.reader.port.name == str(cable.link)


def test_bytes_are_sent_where_a_port_is_open_and_dropped_where_none_is_or_it_takes_none(tmp_path, listen):
    listener = listen(tmp_path / "tty")
    listener.reader.write(b"too early")
    cable = Cable(tmp_path / "tty")
    wait_for(lambda: listener.opened == 1)
    wait_for(lambda: listener.reader.port.name is not None)
    os.set_blocking(cable.device, False)

    def sent():
        listener.reader.write(b"command")
        with suppress(BlockingIOError):
            return os.read(cable.device, 100)
        return b""

    wait_for(lambda: bool(sent()))
    for _ in range(100):
        listener.reader.write(bytes(1000))  # nobody takes them
    cable.unplug()
    wait_for(lambda: listener.reader.port.unplugged == 1)
    listener.reader.write(b"too late")


def test_a_missing_port_is_told_once_and_taken_when_it_comes(tmp_path, listen):
    listener = listen(tmp_path / "tty")
    wait_for(lambda: len(listener.said) == 2)
    time.sleep(0.7)  # two more attempts
    assert len(listener.said) == 2
    assert "no port matches" in listener.said[1]
    assert listener.reader.port.name is None
    cable = Cable(tmp_path / "tty")
    wait_for(lambda: listener.opened == 1)
    assert "reading" in listener.said[2]
    cable.unplug()


def test_a_port_that_comes_back_under_another_name_is_found_by_its_pattern(tmp_path, listen):
    cable = Cable(tmp_path / "ttyACM0")
    listener = listen(tmp_path / "ttyACM*")
    wait_for(lambda: listener.opened == 1)
    cable.unplug()
    wait_for(lambda: listener.reader.port.unplugged == 1)
    cable = Cable(tmp_path / "ttyACM1")
    wait_for(lambda: listener.opened == 2)
    os.write(cable.device, b"again")
    wait_for(lambda: listener.data == b"again")
    assert listener.reader.port.name == str(cable.link)


def test_access_is_exclusive(connected, listen):
    cable, _ = connected
    with pytest.raises(serial.SerialException, match=r"exclusively lock|busy"):
        serial.Serial(str(cable.link), exclusive=True)
    second = listen(cable.link)
    wait_for(lambda: len(second.said) == 2)
    assert "cannot be opened" in second.said[1]
    assert second.reader.port.problem == second.said[1].removesuffix("; trying again until it works")


def test_other_programs_are_kept_out_while_it_reads(connected):
    cable, listener = connected
    assert is_taken(cable.computer)
    listener.reader.stop()
    assert not is_taken(cable.computer)


def test_bytes_that_another_program_took_are_no_unplugged_port(tmp_path, listen):
    cable = Cable(tmp_path / "tty")
    os.set_blocking(cable.computer, False)  # opened before: it reads all the same
    listener = listen(cable.link)
    wait_for(lambda: listener.opened == 1)

    def steal():
        for _ in range(20):
            os.write(cable.device, b"sample")
            with suppress(BlockingIOError):
                os.read(cable.computer, 100)
        return "another program takes bytes from" in listener.said[-1]

    wait_for(steal)
    for _ in range(20):
        steal()
    assert listener.reader.port.unplugged == 0
    assert len(listener.said) == 3


@pytest.mark.parametrize("reset_on_open", [False, True])
def test_dtr_falls_as_the_port_is_closed_only_if_asked(tmp_path, listen, reset_on_open):
    cable = Cable(tmp_path / "tty")
    attributes = termios.tcgetattr(cable.computer)
    attributes[2] ^= (attributes[2] ^ (0 if reset_on_open else termios.HUPCL)) & termios.HUPCL
    termios.tcsetattr(cable.computer, termios.TCSANOW, attributes)
    listener = listen(cable.link, reset_on_open=reset_on_open)
    wait_for(lambda: listener.opened == 1)
    assert bool(termios.tcgetattr(cable.computer)[2] & termios.HUPCL) == reset_on_open


def test_bytes_are_passed_on_as_they_come(connected):
    cable, listener = connected
    late = []
    for count in range(100):
        sent = time.monotonic()
        os.write(cable.device, b"sample")
        wait_for(lambda count=count: len(listener.data) > 6 * count)
        late.append(listener.arrivals[-1] - sent)
    assert np.percentile(late, 10) < 0.0015  # on a busy machine the others wait for their turn


def test_something_that_is_no_serial_port_is_told(tmp_path, listen):
    (tmp_path / "file").write_text("")
    listener = listen(tmp_path / "file")
    wait_for(lambda: len(listener.said) == 2)
    assert "cannot be opened" in listener.said[1]


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_an_error_of_the_program_is_not_taken_for_an_unplugged_port(tmp_path):
    cable = Cable(tmp_path / "tty")

    def fail(_):
        raise RuntimeError("a mistake")

    opened = []
    reader = PortReader(str(cable.link), 115200, lambda: opened.append(1), fail, lambda _: None, lambda _: None)
    reader.start()
    wait_for(lambda: bool(opened))
    os.write(cable.device, b"x")
    wait_for(lambda: reader.failed)
    assert reader.port.unplugged == 0
    reader.stop()


@pytest.mark.parametrize("port", ["", "/", "**", "a\0b", "[", ".", "/dev/zero", "/dev/null", "pipe", "file"])
def test_an_odd_port_is_waited_for_like_any_that_is_not_there(tmp_path, monkeypatch, port):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    Path("file").write_text("")
    listener = Listener(port)
    wait_for(lambda: len(listener.said) > 1)
    assert "trying again until it works" in listener.said[1]
    listener.reader.stop()
    assert not listener.reader.failed
