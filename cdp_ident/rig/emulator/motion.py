# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the pendulum and the cart are while a script goes on: led by the hand, free, or driven as the host commands."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.model.acting import NO_EFFECTS, ActingEffects
from cdp_ident.model.motions import accelerations_at, simulate
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.rig.protocol import WATCHDOG_SECONDS
from cdp_ident.user_input import Limits

_Place = Annotated[float, Limits(-1000.0, 1000.0)]
_Within = Annotated[float, Limits(0.01, 1e6)]
_Size = Annotated[float, Limits(1e-4, 1000.0)]

_LONGEST_STEP = 0.002
"""Step of the integration [s]: its error stays far below an encoder's count."""
_HANGING = np.array([math.pi, math.pi, 0.0, 0.0])


@dataclass(frozen=True)
class Wait:
    """Leave everything as it is: a held pendulum held, a free one swinging."""

    seconds: Annotated[float, Limits(0.0, 1e6)]


@dataclass(frozen=True)
class Hold:
    """Catch the pendulum, lead it to a position in the time `within` [s], and hold it there."""

    theta1: _Place
    """Angle of the inner rod from upright [rad]; likewise the outer rod's."""
    theta2: _Place
    within: _Within = 1.5


@dataclass(frozen=True)
class LetGo:
    """Let the pendulum swing."""


@dataclass(frozen=True)
class MoveCart:
    """Move the cart to a position [m] in the time `within` [s]."""

    to: _Place
    within: _Within = 1.0


@dataclass(frozen=True)
class WaitForCommand:
    """Leave everything as it is until the cart's drive obeys a command."""


Command = Wait | Hold | LetGo | MoveCart | WaitForCommand


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

        The times (n,) [s] count from now on and ascend; the last one is the period's end.
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


@dataclass(frozen=True)
class _Path:
    """A smooth way of one or more coordinates to rest: the polynomial of fifth degree through both ends."""

    begin: float
    """Time at which it begins [s]."""
    duration: float
    start: Array
    speed: Array
    """Speed at the beginning."""
    goal: Array

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return position, speed and acceleration (n, coordinates) at times (n,); after the end it rests."""
        T = self.duration
        s = np.clip((times - self.begin) / T, 0.0, 1.0)[:, None]
        way, lead = self.goal - self.start, self.speed * T
        a, b, c = 10 * way - 6 * lead, -15 * way + 8 * lead, 6 * way - 3 * lead
        position = self.start + s * (lead + s**2 * (a + s * (b + s * c)))
        speed = (lead + s**2 * (3 * a + s * (4 * b + s * 5 * c))) / T
        acceleration = s * (6 * a + s * (12 * b + s * 20 * c)) / T**2
        return position, speed, np.where(s < 1.0, acceleration, 0.0)


class Motion:
    """The motion that a script makes, sample by sample; after its end the last command goes on."""

    def __init__(
        self,
        coefficients: Array,
        script: Sequence[Command],
        period: float,
        effects: ActingEffects = NO_EFFECTS,
        cart: DrivenCart | None = None,
    ) -> None:
        """Begin hanging at rest; coefficients and effects are those of `simulate`, samples come every `period` [s].

        The script says what the hand does, and the cart, unless a `cart` is given that its drive moves.
        """
        self._coefficients = coefficients
        self._effects = effects.only(lambda effect: effect.moves)
        self._commands = deque(script)
        self._period = period
        self._step = period / math.ceil(period / _LONGEST_STEP)
        self._now = 0
        self._left = 0
        self._state = _HANGING
        self._hand: _Path | None = None
        self._cart = _Path(0.0, 1.0, np.zeros(1), np.zeros(1), np.zeros(1))
        self._driven_cart = cart
        self.finished = False
        """Whether the script has come to its end."""

    def advance(self, count: int) -> Array:
        """Return the next samples (count, 8).

        They are the cart [m], theta1 and theta2 from upright [rad], their speeds [rad/s] and accelerations [rad/s^2],
        and the cart's acceleration [m/s^2].
        """
        parts = []
        while count:
            while not self._left and not self.finished:
                self._begin_next()
            length = count if self.finished else min(count, self._left)
            length = 1 if self._driven_cart else length
            parts.append(self._move(length))
            self._now += length
            self._left -= min(length, self._left)
            count -= length
        return np.concatenate(parts)

    def _begin_next(self) -> None:
        command = self._commands.popleft() if self._commands else None
        begin = self._now * self._period
        if isinstance(command, Wait):
            self._left = round(command.seconds / self._period)
        elif isinstance(command, Hold):
            goal = np.array([command.theta1, command.theta2])
            self._hand = _Path(begin, command.within, self._state[:2], self._state[2:4], goal)
            self._left = round(command.within / self._period)
        elif isinstance(command, LetGo):
            self._hand = None
        elif isinstance(command, MoveCart):
            position, speed, _ = self._cart.at(np.array([begin]))
            self._cart = _Path(begin, command.within, position[0], speed[0], np.array([command.to]))
            self._left = round(command.within / self._period)
        elif isinstance(command, WaitForCommand):
            if self._driven_cart is None or not self._driven_cart.obeys:
                self._commands.appendleft(command)
                self._left = 1
        else:
            self.finished = True

    def _move(self, count: int) -> Array:
        begin = self._now * self._period
        ahead: Array = np.asarray(np.arange(1, count + 1) * self._period, dtype=np.float64)
        grid = TimeGrid.over(ahead, self._step)
        x, along, u = self._cart_motion(begin, ahead, grid.half_step_times())
        if self._hand is not None:
            angles, speeds, accelerations = self._hand.at(begin + ahead)
            states = np.hstack([angles, speeds])
        else:
            states = simulate(self._coefficients, self._state, ahead, u, self._step, self._effects, begin)
            accelerations = accelerations_at(self._coefficients, states, along, self._effects, begin + ahead)
        self._state = states[-1]
        return np.column_stack([x, states[:, :4], accelerations, along])

    def _cart_motion(self, begin: float, samples: Array, half_steps: Array) -> tuple[Array, Array, Array]:
        """Return positions [m] and accelerations [m/s^2] at samples, of a driven cart one, and these at half steps."""
        if self._driven_cart is None:
            position, _, acceleration = self._cart.at(begin + samples)
            return position[:, 0], acceleration[:, 0].copy(), self._cart.at(begin + half_steps)[2][:, 0]
        positions, accelerations = self._driven_cart.advance(half_steps)
        return positions[-1:], accelerations[-1:].copy(), accelerations
