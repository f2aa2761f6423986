# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pendulum whose cart is driven: in the cart's frame its acceleration is a part of gravity (d'Alembert)."""

import math

import numpy as np
import numpy.typing as npt

from reference.mechanics import TILT, G
from reference.plant import Path, Plant
from reference.stepping import STATES
from reference.sticking import followed, system_of

Array = npt.NDArray[np.float64]

TOLERANCE = 1e-9
"""Of each step, absolute and relative."""


class DrivenRods:
    """The rods of a plant, on a cart that is accelerated as told; what the plant has a cart of gives way on top."""

    def __init__(self, plant: Plant, start: Array) -> None:
        """Begin at a state (4,): theta1, theta2 [rad], omega1, omega2 [rad/s]."""
        self._system, self._time = system_of(plant), 0.0
        rig = self._system[0]
        self._pull = rig[G] * math.sin(rig[TILT]), rig[G] * math.cos(rig[TILT])
        self._state = np.concatenate([start, np.zeros(STATES - len(start))])
        self.now = Path(np.zeros(1), self._state[None, :4], np.zeros((1, 2)), np.zeros(1))
        """Where they are."""

    def advance(self, pushes: Array, spacing: float) -> None:
        """Go on, the cart's accelerations being `pushes` (n,) [m/s^2] for `spacing` [s] each."""
        rig = self._system[0]
        for u in pushes.tolist():
            across, down = self._pull[0] + u, self._pull[1]
            rig[G], rig[TILT] = math.hypot(across, down), math.atan2(across, down)
            times = np.array([self._time, self._time + spacing])
            after = followed(self._system, self._state, times, TOLERANCE)[0][1:]
            self._time, self._state = times[1], after[0, :STATES]
        self.now = Path(times[1:], after[:, :4], after[:, STATES:], np.zeros(1))
