# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When the next frame is due."""


class RateTimer:
    """Deadlines as far apart as a frequency says, counted from the first, so that they do not drift.

    Where one is missed by more than a second (a computer that slept, a clock that was set) the count begins anew.
    """

    def __init__(self, frequency: float) -> None:
        self._period_ns = 1e9 / frequency
        self._first_ns: int | None = None
        self._count = 0

    def begin_anew(self) -> None:
        """Let the next deadline be at once."""
        self._first_ns = None

    def next_ns(self, now_ns: int) -> int:
        """Return the next deadline [ns]."""
        if self._first_ns is None or abs(self._deadline_ns(self._first_ns) - now_ns) > 1e9 + self._period_ns:
            self._first_ns, self._count = now_ns, 0
        return self._deadline_ns(self._first_ns)

    def advance(self) -> None:
        """Go on to the next deadline."""
        self._count += 1

    def _deadline_ns(self, first_ns: int) -> int:
        return first_ns + round(self._count * self._period_ns)
