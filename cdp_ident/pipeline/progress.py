# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far the search is, shown to people while it runs."""

import time
from collections.abc import Callable

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Display

from cdp_ident.search.genetic_search import Progress

_SECONDS_BETWEEN_LINES, _SECONDS_BETWEEN_TRIES = 2.0, 10.0


class SearchDisplay:
    """A bar with what is done and the time left; where no person sees a terminal, a line now and then."""

    def __init__(self, console: Console, generations: int, clock: Callable[[], float] = time.monotonic) -> None:
        """Make a display for a search of so many generations."""
        self._console, self._clock = console, clock
        self.doing = ""
        """What is done, in words; empty in the end."""
        self._total = generations
        self._began = self._told = clock()
        columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[state]}"))
        self._display = Display(*columns, console=console, transient=True)
        self._task = self._display.add_task("searching", total=None, state="")

    def __enter__(self) -> "SearchDisplay":
        if self._console.is_terminal:
            self._display.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self.doing = ""
        if self._console.is_terminal:
            self._display.stop()

    def show(self, progress: Progress) -> None:
        """Show the progress of the search after a generation."""
        now = self._clock()
        if progress.generation == 0:
            self._began = now
        done = progress.generation / self._total if self._total else 1.0
        left = f", about {(now - self._began) * (1 / done - 1):.0f} s left" if 0 < done < 1 else ""
        state = f"generation {progress.generation} of {self._total}, best error {progress.error:.4g} rad²{left}"
        what = "fitting" if done == 1 else "searching"
        self.doing = f"{what}: {state}"
        self._display.update(self._task, description=what, completed=done, total=1.0, state=state)
        self._tell(0.0 if done == 1 else _SECONDS_BETWEEN_LINES, now)

    def trying(self, line: str) -> None:
        """Show what the tracing tries next, and how long it may take."""
        self.doing = line
        self._display.update(self._task, description="tracing", completed=0.0, total=None, state=line)
        self._tell(_SECONDS_BETWEEN_TRIES, self._clock())

    def _tell(self, seconds: float, now: float) -> None:
        """Print what is done where there is no bar, and so many seconds have passed since the last line."""
        if not self._console.is_terminal and now - self._told >= seconds:
            self._told = now
            self.say(self.doing)

    def say(self, sentence: str) -> None:
        """Print a sentence above the bar."""
        self._console.print(sentence, highlight=False, markup=False)
