# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model's motion from one start on, asked for piece by piece."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.fit.windows import Window
from cdp_ident.model.motions import InitialValueProblem, motions, simulate
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid
from cdp_ident.model.weights import Weight

Array = npt.NDArray[np.float64]

_LATEST = 0.05
"""No encoder is later or earlier than this [s]."""


class MotionStream:
    """What the encoders would show of a motion, and its state; what was asked for long ago is forgotten.

    The integrator's steps are those of one long simulation whatever pieces are asked for, so nothing adds up.
    """

    def __init__(
        self,
        model: FittedModel,
        start: Array,
        trial: int | None = None,
        cart: tuple[Array, Array] | None = None,
        weights: tuple[Weight, ...] = (),
        torques: tuple[Array, Array] | None = None,
    ) -> None:
        """Begin at time 0.

        Args:
            model: gives the motion.
            start: (4,) state at time 0: theta1, theta2 [rad], omega1, omega2 [rad/s].
            trial: the number by which the model knows the trial, for what happened once in it.
            cart: times (n,) [s] and the cart's acceleration at them [m/s^2], in between linear; None for a cart at
                rest.
            weights: that are clamped to the rods.
            torques: times (n,) [s] and motors' torques (n, 2) in the joints at them [N m], likewise.
        """
        self._model, self._cart, self._torques = model, cart, torques
        self._trial = model.trial() if trial is None else trial
        self._weights = weights
        weighted = model.motion.with_weights(model.values, weights)
        self._coefficients = model.motion.coefficients(weighted.values)
        self._effects = model.motion.acting(weighted.values, self._trial, weighted.carried)
        self._step, self._state = 0, np.ascontiguousarray(start, dtype=float)

    def readings(self, times: Array) -> Array:
        """Return theta1 and theta2 (n, 2) [rad] as the encoders show them at ascending times (n,) [s].

        The first time must not be before the first one of the call before.
        """
        times = np.asarray(times, dtype=float)
        self._advance(float(times[0]) - _LATEST)
        since = times - self._now
        grid = TimeGrid.over(since)
        grid = replace(grid, steps=grid.steps + round(_LATEST / DEFAULT_STEP))  # an early encoder sees what comes then
        window = Window(
            self._trial, 0, self._now, since, np.empty((0, 2)), grid, self._u(grid), self._state,
            drive=self._drive(grid), weights=self._weights,
        )  # fmt: skip
        return self._model.motion.predict(self._model.values, self._state, window)

    @property
    def needs_inputs_from(self) -> float:
        """Time from which on inputs still matter [s]."""
        return self._now

    def take_inputs(self, cart: tuple[Array, Array] | None, torques: tuple[Array, Array] | None) -> None:
        """Go on with other inputs."""
        self._cart, self._torques = cart, torques

    def state(self, time: float) -> Array:
        """Return the rods' state (4,) at a time [s] from the first one on that was last asked for."""
        since = np.array([time - self._now])
        u = self._u(TimeGrid.over(since))
        return simulate(self._coefficients, self._state, since, u, DEFAULT_STEP, self._effects, self._now)[0, :4]

    @property
    def _now(self) -> float:
        return self._step * DEFAULT_STEP

    def _advance(self, time: float) -> None:
        """Go to the integrator's last step before a time [s]."""
        steps = int(time / DEFAULT_STEP) - self._step
        if steps <= 0:
            return
        grid = TimeGrid(DEFAULT_STEP, steps, np.empty(0))
        problem = InitialValueProblem(
            self._coefficients, self._state, grid, self._u(grid), self._effects, self._now, self._drive(grid)
        )
        self._state = motions([problem]).ends[0]
        self._step += steps

    def _drive(self, grid: TimeGrid) -> Array | None:
        """Return the motors' torques at the half steps of a grid that begins now."""
        return grid.at_half_steps(*self._torques, self._now) if self._torques else None

    def _u(self, grid: TimeGrid) -> Array:
        """Return the cart's acceleration at the half steps of a grid that begins now."""
        if self._cart is None:
            return np.zeros(2 * grid.steps + 1)
        half_steps = (2 * self._step + np.arange(2 * grid.steps + 1)) * (0.5 * DEFAULT_STEP)
        return np.asarray(np.interp(half_steps, *self._cart), dtype=float)
