# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated cable: what goes wrong on it, and its end at the computer, a pseudo-terminal behind a link."""

import errno
import fcntl
import os
import termios
import time
import tty
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from cdp_ident.errors import RigError
from cdp_ident.files import beside
from cdp_ident.user_input import Limits

SECONDS = Limits(0.0, 1e9)
_Probability = Annotated[float, Limits(0.0, 1.0)]
_PATIENCE = 0.5
"""Bytes wait this long for a computer that takes none [s]: it is busy, or nobody has opened the port."""
_LONGEST_READ = 65536


@dataclass(frozen=True)
class Faults:
    """How often what goes wrong; nothing by default."""

    flips: _Probability = 0.0
    """Probability that a byte has one of its bits flipped."""
    losses: _Probability = 0.0
    """Probability that a byte is lost."""
    bursts: Annotated[float, SECONDS] = 0.0
    """Bursts of up to 200 arbitrary bytes, on average [1/s]."""
    delay: Annotated[float, SECONDS] = 0.0
    """Bytes come in batches up to this late, as from USB adapters [s]."""
    stall_every: Annotated[float, SECONDS] = 0.0
    """Time from one stall to the next [s], 0 for never."""
    stall_for: Annotated[float, SECONDS] = 0.5
    """How long nothing comes in a stall; then all comes at once [s]."""


class Line:
    """A cable with faults: takes bytes at the time they are sent, and gives them at the time they arrive."""

    def __init__(self, faults: Faults, generator: np.random.Generator) -> None:
        self._faults = faults
        self._generator = generator
        self._underway: deque[tuple[float, bytes]] = deque()
        self._batch_end = 0.0
        self._last = 0.0

    def send(self, data: bytes, now: float) -> None:
        """Put bytes on the line at time `now` [s], which never goes back."""
        faults = self._faults
        if now >= self._batch_end:
            self._batch_end = now + self._generator.uniform(0.0, faults.delay)
        arrival = self._batch_end if faults.delay else now
        if faults.stall_every and now % faults.stall_every < faults.stall_for and now > faults.stall_every:
            arrival = max(arrival, now - now % faults.stall_every + faults.stall_for)
        self._underway.append((arrival, self._damage(data, now - self._last)))
        self._last = now

    def receive(self, now: float) -> bytes:
        """Return what has arrived at time `now` [s], in the order in which it was sent."""
        arrived = b""
        while self._underway and self._underway[0][0] <= now:
            arrived += self._underway.popleft()[1]
        return arrived

    def _damage(self, data: bytes, elapsed: float) -> bytes:
        faults, generator = self._faults, self._generator
        if faults.flips or faults.losses:
            damaged = np.frombuffer(data, np.uint8).copy()
            flipped = generator.random(len(damaged)) < faults.flips
            damaged[flipped] ^= (1 << generator.integers(0, 8, flipped.sum())).astype(np.uint8)
            data = damaged[generator.random(len(damaged)) >= faults.losses].tobytes()
        if faults.bursts and generator.random() < faults.bursts * elapsed:
            data += generator.bytes(int(generator.integers(1, 201)))
        return data


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
