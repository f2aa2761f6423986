# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the pendulum and the cart are while the script goes on: led by the hand, or free by the equations of motion."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.model.acting import NO_EFFECTS, ActingEffects
from cdp_ident.model.motions import accelerations_at, simulate
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.rig.emulator.drive import DrivenCart
from cdp_ident.rig.emulator.script import Command, Hold, LetGo, MoveCart, Wait, WaitForCommand

Array = npt.NDArray[np.float64]

_LONGEST_STEP = 0.002
"""Step of the integration [s]: its error stays far below an encoder's count."""
_HANGING = np.array([math.pi, math.pi, 0.0, 0.0])


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
        """Begin hanging at rest.

        Args:
            coefficients: those of `simulate`, as are `effects`.
            script: what the hand does, and the cart, unless it is driven.
            period: time between samples [s].
            effects: that act.
            cart: moves as its drive is commanded.
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
