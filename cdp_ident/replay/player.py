# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Plays a scene frame by frame."""

from collections import deque

import numpy as np
import numpy.typing as npt

from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.replay.scene import Frame, Scene

Array = npt.NDArray[np.float64]

_AHEAD = 10
"""So many frames are computed at once."""
_END_TOLERANCE = 1e-9
"""A frame so little [s] after the scene's end is still shown: the time of a sample is a sum of rounded numbers."""


class Player:
    """Gives the frames of a scene, one after another, as evenly spaced in the motion's time as they are shown."""

    def __init__(self, scene: Scene, frequency: float, rate: float = 1.0, loop: bool = True) -> None:
        """Begin at the scene's beginning.

        Args:
            scene: what is played.
            frequency: frames in a second of the viewer's time [Hz].
            rate: the motion's time against the viewer's.
            loop: whether it begins anew at the end.

        Raises:
            SimulationError: not even the first frames can be computed.
        """
        self.finished = False
        """Whether the scene has come to its end."""
        self._scene, self._frequency, self._rate, self._loop = scene, frequency, rate, loop
        self._begin = 0.0
        self._count = 0
        self._played = 0.0
        self._ahead: deque[Frame] = deque()
        self._compute()  # compiles, before anyone waits for the first frame

    @property
    def played(self) -> float:
        """How much of the motion's time was played before the next frame, loops and all [s]."""
        return self._played + self._count * self._rate / self._frequency

    def next(self) -> Frame | None:
        """Return the next frame, None where the scene has ended. Raises `SimulationError`."""
        if not self._ahead:
            self._compute()
        if not self._ahead and self._loop:
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
        self._go_on_from(0.0)
        self.finished = False

    def take_model(self, model: FittedModel) -> None:
        """Show another model from the next frame on."""
        self._scene.take_model(model, self._time(0))
        self._ahead.clear()

    def take_rate(self, rate: float) -> None:
        """Go on at another rate."""
        self._go_on_from(self._time(0))
        self._rate = rate

    def take_loop(self, loop: bool) -> None:
        """Begin anew at the end, be it reached already, or not."""
        self._loop = loop
        self.finished = self.finished and not loop

    def _go_on_from(self, time: float) -> None:
        self._played = self.played
        self._begin, self._count = time, 0
        self._ahead.clear()

    def _time(self, ahead: int) -> float:
        """Return the time of the frame so many after the next [s]."""
        return self._begin + (self._count + ahead) * self._rate / self._frequency

    def _compute(self) -> None:
        times = np.array([self._time(ahead) for ahead in range(_AHEAD)])
        times = times[times <= self._scene.duration + _END_TOLERANCE]
        if len(times):
            self._ahead.extend(self._scene.frames(times))
