# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The cable with faults, and its end at the computer."""

import fcntl
import struct
import termios
import threading

import numpy as np
import pytest
import serial

from cdp_ident.errors import RigError
from cdp_ident.rig.emulator.cable import Faults, Line, PseudoTerminal


def drive(faults, seconds=20.0):
    """Send 100 bytes every 10 ms; return what was sent, what arrived, and how late each 10 ms was."""
    line = Line(faults, np.random.default_rng(1))
    sent, arrived, times = b"", b"", []
    for step in range(int(seconds * 100)):
        data = bytes([step % 251]) * 100
        sent += data
        line.send(data, step * 0.01)
        arrived += line.receive(step * 0.01)
        times.append((len(sent) - len(arrived)) / 10_000)
    return sent, arrived + line.receive(1e9), times


def test_a_good_cable_changes_nothing():
    sent, arrived, late = drive(Faults())
    assert arrived == sent
    assert max(late) == 0.0


def test_flips_are_as_frequent_as_told_and_of_one_bit():
    sent, arrived, _ = drive(Faults(flips=0.01))
    changed = np.frombuffer(sent, np.uint8) ^ np.frombuffer(arrived, np.uint8)
    assert np.mean(changed > 0) == pytest.approx(0.01, rel=0.1)
    assert all(int(bits).bit_count() == 1 for bits in changed[changed > 0])


def test_losses_are_as_frequent_as_told():
    sent, arrived, _ = drive(Faults(losses=0.02))
    assert len(arrived) / len(sent) == pytest.approx(0.98, abs=0.002)


def test_bursts_add_bytes():
    sent, arrived, _ = drive(Faults(bursts=1.0))
    assert 500 < len(arrived) - len(sent) < 5000


def test_a_delay_gathers_batches_and_loses_nothing():
    sent, arrived, late = drive(Faults(delay=0.1))
    assert arrived == sent
    assert 0.05 < max(late) <= 0.11


def test_a_stall_holds_everything_back_and_then_gives_it():
    sent, arrived, late = drive(Faults(stall_every=5.0, stall_for=1.0))
    assert arrived == sent
    assert max(late) == pytest.approx(1.0, abs=0.02)
    assert late[480] == 0.0


def test_more_than_its_buffer_comes_through_in_order(tmp_path):
    terminal = PseudoTerminal(tmp_path / "tty")
    sent = bytes(range(256)) * 400
    received = bytearray()
    done = threading.Event()

    def read():
        with serial.Serial(str(tmp_path / "tty"), timeout=1.0) as port:
            opened.set()
            while len(received) < len(sent):
                received.extend(port.read(4096))
        done.set()

    opened = threading.Event()
    threading.Thread(target=read, daemon=True).start()
    assert opened.wait(60.0)
    terminal.write(sent)
    while not done.wait(0.01):
        terminal.write(b"")
    assert bytes(received) == sent
    terminal.unplug()


def test_what_nobody_reads_is_not_hoarded(tmp_path):
    terminal = PseudoTerminal(tmp_path / "tty")
    terminal._taken -= 10.0
    for _ in range(1000):
        terminal.write(b"x" * 1000)
        terminal._taken -= 10.0
    assert len(terminal._pending) <= 1000
    terminal.unplug()


def test_a_port_whose_reader_was_killed_can_be_opened_again(tmp_path):
    terminal = PseudoTerminal(tmp_path / "tty")

    def is_taken():
        return bool(struct.unpack("i", fcntl.ioctl(terminal._computer, 0x80045440, bytes(4)))[0])  # TIOCGEXCL

    fcntl.ioctl(terminal._computer, termios.TIOCEXCL)
    assert is_taken()
    for _ in range(200):  # more than any kernel keeps
        terminal.write(b"x" * 1000)
        terminal._taken -= 10.0
    assert not is_taken()
    terminal.unplug()


def test_a_new_port_takes_the_place_of_a_link_left_behind_and_removes_only_its_own(tmp_path):
    link = tmp_path / "tty"
    link.symlink_to("/dev/pts/99999")
    first = PseudoTerminal(link)
    second = PseudoTerminal(link)
    first.unplug()
    assert link.is_symlink()
    second.unplug()
    assert not link.is_symlink()
    assert list(tmp_path.iterdir()) == []


def test_a_link_of_the_user_s_stays(tmp_path):
    (tmp_path / "tty").symlink_to("ttyACM0")
    with pytest.raises(RigError, match="something else is there"):
        PseudoTerminal(tmp_path / "tty")
    assert str((tmp_path / "tty").readlink()) == "ttyACM0"


def test_a_link_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    for link in ("file/tty", "a" * 300):
        with pytest.raises(RigError, match="cannot be made"):
            PseudoTerminal(tmp_path / link)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
