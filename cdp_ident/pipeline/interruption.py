"""Ctrl-C while a search runs."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any


class Interruption:
    """While a search runs the first SIGINT only asks it to stop; any other one does what it did before."""

    def __init__(self) -> None:
        self.asked = False
        """Whether the search that runs has been asked to stop."""
        self.given_up = False
        """Whether nobody waits for the result any more."""
        self._searching = False
        self._before: Callable[[int, FrameType | None], Any] | None = None

    def install(self) -> None:
        """Take SIGINT over, in the main thread; a SIGINT that is ignored stays so."""
        before = signal.getsignal(signal.SIGINT)
        if callable(before):
            self._before = before
            signal.signal(signal.SIGINT, self._handle)

    def remove(self) -> None:
        """Give SIGINT back."""
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
            self._before = None

    @contextmanager
    def searching(self) -> Iterator[None]:
        """Say that a search runs."""
        self.asked, self._searching = False, True
        try:
            yield
        finally:
            self._searching = False

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self._searching and not self.asked:
            self.asked = True
        elif self._before is not None:
            self._before(number, frame)


class GivenUpError(Exception):
    """An identification ends because nobody waits for it any more."""
