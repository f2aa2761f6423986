"""The serial port: found, opened exclusively, read, and found again after it was unplugged."""

import glob
import os
import termios
import threading
import time
from collections.abc import Callable

import serial

from cdp_ident.outside_text import shown

_FIRST_PAUSE, _LONGEST_PAUSE = 0.2, 2.0
"""Between attempts to open the port; each pause doubles the one before [s]."""
_READ_TIMEOUT = 0.1
"""A read that brings nothing ends after this, to look whether to stop [s]."""
_GATHER = 0.004
"""After the first byte, others are let come for this long: it halves the CPU at 1 kHz [s]."""


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
    ) -> None:
        """`on_open`, `on_bytes`, `say` and `warn` (a sentence for the log) are called in the reading thread."""
        self.failed = False
        """Whether reading ended by an error of the program, which no waiting mends."""
        self.unplugged = 0
        """How often an open port went away."""
        self._pattern = os.path.abspath(pattern).replace("\0", "?") if pattern else "(none)"  # noqa: PTH100 - of any text
        self._baud = baud
        self._on_open, self._on_bytes, self._say, self._warn = on_open, on_bytes, say, warn
        self._stop = threading.Event()
        self._port: str | None = None
        self._problem = "not opened yet"
        self._thread = threading.Thread(target=self._run, name="serial port", daemon=True)

    @property
    def port(self) -> str | None:
        """Name of the open port, None while none is open."""
        return self._port

    @property
    def problem(self) -> str:
        """Why no port is open."""
        return self._problem

    def start(self) -> None:
        """Begin to look for the port and to read it."""
        self._thread.start()

    def stop(self) -> None:
        """Close the port and end the thread."""
        self._stop.set()
        self._thread.join(timeout=5.0)

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
                    self._warn(f"{self._problem}; trying again until it works")
                    warned = True
                self._stop.wait(pause)
                pause = min(2 * pause, _LONGEST_PAUSE)
                continue
            pause, warned = _FIRST_PAUSE, False
            self._say(f"reading {self._port} at {self._baud} baud")
            self._on_open()
            with connection:
                self._problem = self._read(connection)
            if not self._stop.is_set():
                self.unplugged += 1
                self._warn(f"{self._port} went away ({self._problem}); trying again until it is back")
                warned = True
            self._port = None

    def _open(self) -> serial.Serial | None:
        self._problem = f"no port matches {shown(self._pattern)}"
        for name in sorted(glob.glob(self._pattern)):  # noqa: PTH207 - Path.glob raises for odd patterns
            try:
                connection = serial.Serial(name, self._baud, timeout=_READ_TIMEOUT, exclusive=True)
            except (OSError, ValueError, termios.error) as error:  # SerialException is an OSError; ValueError: the baud
                self._problem = f"{shown(name)} cannot be opened: {shown(error)}"
            else:
                self._port = shown(name)
                return connection
        return None

    def _read(self, connection: serial.Serial) -> str:
        """Read until the port goes away or `stop`; return why it ended."""
        try:
            while not self._stop.is_set():
                data = connection.read(1)
                if data:
                    time.sleep(_GATHER)
                    self._on_bytes(data + connection.read(connection.in_waiting))
        except (OSError, termios.error) as error:
            return shown(error)
        return "stopped"
