# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Plays a scene frame by frame, and says when the next frame is due."""

from collections import deque
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated

import numpy as np

from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.replay.scene import Frame, Scene
from cdp_ident.user_input import Limits

_AHEAD = 10
"""So many frames are computed at once."""
_END_TOLERANCE = 1e-9
"""A frame so little [s] after the scene's end is still shown: the time of a sample is a sum of rounded numbers."""


@dataclass(frozen=True)
class Pace:
    """How a motion is played."""

    frequency: Annotated[float, Limits(1.0, 1000.0)] = 200.0
    """Frames a second [Hz]."""
    rate: Annotated[float, Limits(1e-6, 1e6, changeable=True)] = 1.0
    """The motion's time against the clock's."""
    loop: Annotated[bool, Limits(changeable=True)] = True
    """Begin anew at the end of the trial."""
    clock: bool = False
    """Publish the motion's time as /clock; the pace is then the wall's."""


class Player:
    """Gives the frames of a scene, one after another, as evenly spaced in the motion's time as they are shown."""

    def __init__(self, scene: Scene, pace: Pace) -> None:
        """Begin at the scene's beginning. Raises `SimulationError` where not even the first frames can be computed."""
        self.finished = False
        """Whether the scene has come to its end."""
        self._scene, self._pace = scene, pace
        self._before = 0.0
        """How much was played before the scene began for the last time [s]."""
        self._ahead: deque[Frame] = deque()
        self._go_on_from(0.0)
        self._compute()  # compiles, before anyone waits for the first frame

    @property
    def played(self) -> float:
        """How much of the motion's time was played before the next frame, loops and all [s]."""
        return self._before + self._time()

    def next(self) -> Frame | None:
        """Return the next frame, None where the scene has ended. Raises `SimulationError`."""
        if not self._ahead:
            self._compute()
        if not self._ahead and self._pace.loop:
            self.restart()
            self._compute()
        if not self._ahead:
            self.finished = True
            return None
        self._count += 1
        return self._ahead.popleft()

    def restart(self) -> None:
        """Go to the scene's beginning."""
        self._scene.restart()
        self._before = self.played
        self._go_on_from(0.0)
        self.finished = False

    def take_model(self, model: FittedModel) -> None:
        """Show another model from the next frame on."""
        self._scene.take_model(model, self._time())
        self._ahead.clear()

    def take_pace(self, pace: Pace) -> None:
        """Go on at another rate, and begin anew at the end, be it reached already, or not."""
        self._go_on_from(self._time())
        self._pace, self.finished = pace, self.finished and not pace.loop

    def _go_on_from(self, time: float) -> None:
        self._begin, self._count = time, 0
        self._ahead.clear()

    def _time(self, ahead: int = 0) -> float:
        """Return the time of the frame so many after the next [s]."""
        return self._begin + (self._count + ahead) * self._pace.rate / self._pace.frequency

    def _compute(self) -> None:
        times = np.array([self._time(ahead) for ahead in range(_AHEAD)])
        times = times[times <= self._scene.duration + _END_TOLERANCE]
        if len(times):
            self._ahead.extend(self._scene.frames(times))


class RateTimer:
    """Deadlines as far apart as a frequency says, to the fraction of a nanosecond, so that they do not drift.

    Where one is missed by more than a second (a computer that slept, a clock that was set) they begin anew.
    """

    def __init__(self, frequency: float) -> None:
        self._period = 1_000_000_000 / Fraction(frequency)
        self._due: Fraction | None = None
        """The next deadline [ns]; None where that is at once."""

    def begin_anew(self) -> None:
        """Let the next deadline be at once."""
        self._due = None

    def next_ns(self, now_ns: int) -> int:
        """Return the next deadline [ns]."""
        if self._due is None or abs(self._due - now_ns) > 1_000_000_000 + self._period:
            self._due = Fraction(now_ns)
        return round(self._due)

    def advance(self) -> None:
        """Go on to the next deadline."""
        if self._due is not None:
            self._due += self._period
