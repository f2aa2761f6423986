# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated port by itself."""

import fcntl
import struct
import termios
import threading

import pytest
import serial

from cdp_ident.errors import RigError
from cdp_ident.rig.emulator.pseudo_terminal import PseudoTerminal


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
