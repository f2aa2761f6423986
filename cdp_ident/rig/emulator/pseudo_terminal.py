# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated cable's end at the computer: a pseudo-terminal behind a link."""

import errno
import fcntl
import os
import termios
import time
import tty
from contextlib import suppress
from pathlib import Path

from cdp_ident.errors import RigError
from cdp_ident.files import beside

_PATIENCE = 0.5
"""Bytes wait this long for a computer that takes none [s]: it is busy, or nobody has opened the port."""

_LONGEST_READ = 65536


class PseudoTerminal:
    """A serial port that programs open under the name `link`."""

    def __init__(self, link: Path) -> None:
        """Make the port. Raises `RigError` where the link's place is taken by something else or not writable."""
        self.link = link
        self._device, self._computer = os.openpty()
        port = Path(os.ttyname(self._computer))
        tty.setraw(self._computer)
        os.set_blocking(self._device, False)
        self._pending = b""
        self._taken = time.monotonic()
        try:
            if os.path.lexists(link) and not (link.is_symlink() and link.readlink().parent == port.parent):
                raise FileExistsError(errno.EEXIST, "something else is there")
            link.parent.mkdir(parents=True, exist_ok=True)
            new = beside(link)
            new.symlink_to(port)
            try:
                new.replace(link)
            finally:
                new.unlink(missing_ok=True)
        except OSError as error:
            self.unplug()
            raise RigError(f"the link {link} cannot be made: {error.strerror}; give --link another name") from error

    def write(self, data: bytes) -> None:
        """Send bytes. What the computer takes too late is lost, as on a cable that nobody listens to."""
        self._pending += data
        try:
            while self._pending:
                self._pending = self._pending[os.write(self._device, self._pending) :]
                self._taken = time.monotonic()
        except BlockingIOError:
            if time.monotonic() - self._taken > _PATIENCE:
                self._pending = b""
                fcntl.ioctl(self._computer, termios.TIOCNXCL)  # whoever had it to himself was killed

    def read(self) -> bytes:
        """Return the bytes that the computer has sent."""
        try:
            return os.read(self._device, _LONGEST_READ)
        except BlockingIOError:
            return b""

    def unplug(self) -> None:
        """Take the port away; whoever reads it notices."""
        with suppress(OSError):
            if str(self.link.readlink()) == os.ttyname(self._computer):
                self.link.unlink()
        os.close(self._device)
        os.close(self._computer)
