# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C, or a request to end, while an identification runs."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interruption:
    """Until a result is written the first signal only asks the search to stop; others do what they did before."""

    def __init__(self) -> None:
        self.asked = False
        """Whether the identification that runs has been asked to stop."""
        self.ends = False
        """Whether the program shall end once the result is there: by SIGTERM, or asked when no search ran any more."""
        self.given_up = False
        """Whether nobody waits for the result any more."""
        self._identifying = self._searching = False
        self._before: dict[int, Callable[[int, FrameType | None], Any] | int | None] = {}

    def install(self) -> None:
        """Take SIGINT and SIGTERM over, in the main thread; one that is ignored stays so."""
        for number in _SIGNALS:
            if signal.getsignal(number) not in (signal.SIG_IGN, None):
                self._before[number] = signal.signal(number, self._handle)

    def remove(self) -> None:
        """Give the signals back."""
        while self._before:
            signal.signal(*self._before.popitem())

    def cancel(self) -> bool:
        """Ask the search that runs to stop, as a first SIGINT does; return whether one runs."""
        self.asked |= self._searching
        return self._searching

    @contextmanager
    def identifying(self) -> Iterator[None]:
        """Say that an identification runs whose result is not written yet."""
        self.asked, self._identifying = False, True
        try:
            yield
        finally:
            self._identifying = False

    @contextmanager
    def searching(self) -> Iterator[None]:
        """Say that its search runs."""
        self._searching = True
        try:
            yield
        finally:
            self._searching = False

    def _handle(self, number: int, frame: FrameType | None) -> None:
        before = self._before.get(number)
        if self._identifying and not self.asked:
            self.asked = True
            self.ends = number == signal.SIGTERM or not self._searching
        elif callable(before):
            before(number, frame)
        elif before is signal.SIG_DFL:
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)


class GivenUpError(Exception):
    """An identification ends because nobody waits for it any more."""
