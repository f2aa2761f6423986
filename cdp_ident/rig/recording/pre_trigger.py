# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The messages from shortly before a release, which belong to the trial too."""

from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

_MOST_BYTES = 64_000_000
"""A minute at 5 kHz has so many."""


class Message(NamedTuple):
    """A serialised message, as a recorder gets it."""

    topic: str
    message_type: str
    received_ns: int
    """Time of its receipt [ns since the epoch]."""
    raw: bytes


class PreTrigger:
    """Keeps the messages of the last seconds."""

    def __init__(self, duration: float) -> None:
        """Keep messages for a duration [s], as far as they are not too large."""
        self._duration_ns = duration * 1e9
        self._messages: deque[Message] = deque()
        self._bytes = 0

    def __iter__(self) -> Iterator[Message]:
        """Yield the messages, the oldest first."""
        return iter(tuple(self._messages))

    def keep(self, message: Message) -> None:
        """Add a message, the newest one, and drop those that are older than the duration.

        Messages from after it go too: they were received before the clock was set back.
        """
        now = message.received_ns
        self._messages.append(message)
        self._bytes += len(message.raw)
        oldest = now - self._duration_ns
        while not oldest <= self._messages[0].received_ns <= now or self._bytes > _MOST_BYTES:
            self._bytes -= len(self._messages.popleft().raw)
            if not self._messages:
                return
