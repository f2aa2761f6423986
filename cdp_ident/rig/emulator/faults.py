# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can go wrong between a rig and the computer."""

from collections import deque
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from cdp_ident.user_input import Limits

SECONDS = Limits(0.0, 1e9)
_Probability = Annotated[float, Limits(0.0, 1.0)]


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
