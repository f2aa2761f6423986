"""The emulated cable's end at the computer: a pseudo-terminal behind a link."""

import os
import tty
from contextlib import suppress
from pathlib import Path

from cdp_ident.errors import RigError


class PseudoTerminal:
    """A serial port that programs open under the name `link`."""

    def __init__(self, link: Path) -> None:
        """Make the port. Raises `RigError` where the link's place is taken by something else or not writable."""
        if link.exists() and not link.is_symlink():
            raise RigError(f"{link} is there and is no link: give --link another name")
        self.link = link
        self._device, self._computer = os.openpty()
        tty.setraw(self._computer)
        os.set_blocking(self._device, False)
        beside = link.with_name(f".{link.name}.{os.getpid()}")
        try:
            link.parent.mkdir(parents=True, exist_ok=True)
            beside.unlink(missing_ok=True)
            beside.symlink_to(os.ttyname(self._computer))
            beside.replace(link)
        except OSError as error:
            self.unplug()
            raise RigError(f"the link {link} cannot be made: {error.strerror}") from error

    def write(self, data: bytes) -> None:
        """Send bytes. What the computer does not take in time is lost, as on a cable."""
        while data:
            try:
                data = data[os.write(self._device, data) :]
            except BlockingIOError:
                return

    def unplug(self) -> None:
        """Take the port away; whoever reads it notices."""
        with suppress(OSError):
            if str(self.link.readlink()) == os.ttyname(self._computer):
                self.link.unlink()
        os.close(self._device)
        os.close(self._computer)
