# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The serial port: found, opened exclusively, read and written, and found again after it was unplugged."""

import fcntl
import glob
import os
import select
import termios
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import serial

from cdp_ident.outside_text import shown

_FIRST_PAUSE, _LONGEST_PAUSE = 0.2, 2.0
"""Between attempts to open the port; each pause doubles the one before [s]."""
_READ_TIMEOUT = 0.1
"""A read that brings nothing ends after this, to look whether to stop [s]."""
_LEAST_PERIOD = 0.002
"""From one read to the next, bytes are let come for this long [s]: frames that come faster come in twos and more."""
_LONGEST_READ = 65536


@dataclass
class PortState:
    """What a port's reader says of it."""

    name: str | None = None
    """The open port, None while none is open."""
    problem: str = "not opened yet"
    """Why none is open."""
    unplugged: int = 0
    """How often an open port went away."""


class PortReader:
    """Reads a serial port in a thread of its own, whatever happens to the port.

    The port may be given as a pattern (`/dev/serial/by-id/usb-*`): the first one that opens is taken. A port that is
    missing, busy or unplugged is tried again with growing pauses, and is reported once.
    """

    def __init__(
        self,
        pattern: str,
        baud: int,
        on_open: Callable[[], None],
        on_bytes: Callable[[bytes], None],
        say: Callable[[str], None],
        warn: Callable[[str], None],
        reset_on_open: bool = False,
    ) -> None:
        """`on_open`, `on_bytes`, `say` and `warn` (a sentence for the log) are called in the reading thread.

        `reset_on_open` lets the DTR line fall as the port is closed, so that to open it again resets many boards.
        """
        self.failed = False
        """Whether reading ended by an error of the program, which no waiting mends."""
        self.port = PortState()
        """Changed in the reading thread."""
        self._pattern = os.path.abspath(pattern).replace("\0", "?") if pattern else "(none)"  # noqa: PTH100 - of any text
        self._baud, self._reset_on_open = baud, reset_on_open
        self._on_open, self._on_bytes, self._say, self._warn = on_open, on_bytes, say, warn
        self._open_port: int | None = None
        """Its descriptor, for `write`; changed under the lock, that no other file has come by its number."""
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="serial port", daemon=True)

    def start(self) -> None:
        """Begin to look for the port and to read it."""
        self._thread.start()

    def stop(self) -> None:
        """Close the port and end the thread."""
        self._stop.set()
        self._thread.join(timeout=5.0)

    def write(self, data: bytes) -> None:
        """Send bytes, from any thread, if a port is open that takes them at once; later they would be out of date."""
        with self._lock, suppress(OSError):  # the reading thread notices that it went away
            if self._open_port is not None:
                os.write(self._open_port, data)

    def _run(self) -> None:
        try:
            self._keep_reading()
        finally:
            self.failed = not self._stop.is_set()

    def _keep_reading(self) -> None:
        pause, warned = _FIRST_PAUSE, False
        while not self._stop.is_set():
            connection = self._open()
            if connection is None:
                if not warned:
                    self._warn(f"{self.port.problem}; trying again until it works")
                    warned = True
                self._stop.wait(pause)
                pause = min(2 * pause, _LONGEST_PAUSE)
                continue
            pause, warned = _FIRST_PAUSE, False
            self._say(f"reading {self.port.name} at {self._baud} baud")
            self._on_open()
            with connection:
                self.port.problem = self._read(connection)
            if not self._stop.is_set():
                self.port.unplugged += 1
                self._warn(f"{self.port.name} went away ({self.port.problem}); trying again until it is back")
                warned = True
            self.port.name = None

    def _open(self) -> serial.Serial | None:
        self.port.problem = f"no port matches {shown(self._pattern)}"
        for name in sorted(glob.glob(self._pattern)):  # noqa: PTH207 - Path.glob raises for odd patterns
            try:
                connection = serial.Serial(name, self._baud, exclusive=True)
                self._set_up(connection.fd)
            except (OSError, ValueError, termios.error) as error:  # SerialException is an OSError; ValueError: the baud
                self.port.problem = f"{shown(name)} cannot be opened: {shown(error)}"
            else:
                self.port.name = shown(name)
                return connection
        return None

    def _set_up(self, descriptor: int) -> None:
        """Let no other program open the port, tell nothing to read from the port's end, and keep DTR as it is."""
        fcntl.ioctl(descriptor, termios.TIOCEXCL)
        attributes = termios.tcgetattr(descriptor)
        attributes[2] = attributes[2] | termios.HUPCL if self._reset_on_open else attributes[2] & ~termios.HUPCL
        attributes[6][termios.VMIN] = 1
        termios.tcsetattr(descriptor, termios.TCSANOW, attributes)

    def _read(self, connection: serial.Serial) -> str:
        """Read until the port goes away or `stop`; return why it ended."""
        due, stolen = 0.0, False
        self._open_port = connection.fd
        try:
            while not self._stop.is_set():
                if not select.select([connection.fd], [], [], _READ_TIMEOUT)[0]:
                    continue
                time.sleep(max(0.0, due - time.monotonic()))
                due = time.monotonic() + _LEAST_PERIOD
                try:
                    data = os.read(connection.fd, _LONGEST_READ)
                except BlockingIOError:
                    if not stolen:
                        self._warn(f"another program takes bytes from {self.port.name}, which are lost: end it")
                    stolen = True
                    continue
                if not data:
                    return "it has ended"
                self._on_bytes(data)
        except OSError as error:
            return shown(error)
        finally:
            with self._lock:
                self._open_port = None
            with suppress(OSError):
                fcntl.ioctl(connection.fd, termios.TIOCNXCL)
        return "stopped"
