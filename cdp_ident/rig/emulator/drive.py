# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated cart and its drive, which the host commands: its limits hold whatever it is asked for."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from cdp_ident.rig.protocol import WATCHDOG_SECONDS
from cdp_ident.user_input import Limits

Array = npt.NDArray[np.float64]
_Size = Annotated[float, Limits(1e-4, 1000.0)]


@dataclass(frozen=True)
class Drive:
    """What a cart's drive can do."""

    lag: _Size = 0.01
    """Time constant with which the cart follows its set point [s]."""
    acceleration: _Size = 20.0
    """The largest [m/s^2]."""
    speed: _Size = 3.0
    """The highest [m/s]."""
    rail: _Size = 0.5
    """The cart stays within so much of its zero [m]."""


class DrivenCart:
    """A cart that follows commanded accelerations as far as its drive's limits allow.

    The device integrates commands to a set point, whose limits it keeps: each bounds the set point's next speed, the
    rail's end by the highest speed from which the drive can still brake. The cart follows with a lag of first order:
    its position, speed and acceleration are means of the set point's, so they keep the limits, too.
    """

    def __init__(self, drive: Drive) -> None:
        """Rest at the rail's middle, which is the position 0."""
        self._drive = drive
        self._position = self._set_point = self._speed = 0.0
        """Of the cart, and of its set point the position and speed."""
        self._commanded = 0.0
        self._silent = math.inf

    @property
    def obeys(self) -> bool:
        """Whether the last command still holds."""
        return self._silent < WATCHDOG_SECONDS

    def command(self, acceleration: float) -> None:
        """Take the next command [m/s^2]."""
        self._commanded, self._silent = acceleration, 0.0

    def forget_command(self) -> None:
        """Brake until the next command comes: the device was reset."""
        self._silent = math.inf

    def advance(self, times: Array) -> tuple[Array, Array]:
        """Go on by one period of the device; return the cart's positions [m] and accelerations [m/s^2] at times in it.

        Args:
            times: (n,) [s] from now on, ascending; the last one is the period's end.
        """
        period, lag, begin = float(times[-1]), self._drive.lag, self._set_point
        u = (self._next_speed(period) - self._speed) / period
        speeds = self._speed + u * times
        settled = begin + (self._speed + 0.5 * u * times) * times - lag * (speeds - lag * u)
        fading = (self._position - begin + lag * (self._speed - lag * u)) * np.exp(-times / lag)
        self._set_point += (self._speed + 0.5 * u * period) * period
        self._speed += u * period
        self._position = float(settled[-1] + fading[-1])
        self._silent += period
        return settled + fading, u + fading / lag**2

    def _next_speed(self, period: float) -> float:
        """Return the set point's speed at the period's end [m/s]: what is asked for, within all limits."""
        drive, change = self._drive, self._drive.acceleration * period
        asked = self._speed + self._commanded * period if self.obeys else 0.0
        middle = self._set_point + 0.5 * self._speed * period

        def highest(way: float) -> float:
            """Return the speed from which it still stops on its way to the rail's end."""
            return min(drive.speed, math.sqrt(max(0.0, 0.25 * change**2 + 2 * drive.acceleration * way)) - 0.5 * change)

        end = drive.rail - change * period / 8  # so far at most it goes on while it turns round
        asked = min(max(asked, -highest(end + middle)), highest(end - middle))
        return min(max(asked, self._speed - change), self._speed + change)
