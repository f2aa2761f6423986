# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can be shown: a motion of the model alone, or beside a recorded trial."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from cdp_ident.arrays import Array
from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.diagnosis.evaluation import start_of
from cdp_ident.errors import SimulationError
from cdp_ident.fit.windows import DEFAULT_WINDOW, Window
from cdp_ident.model.motions import InitialValueProblem, motions, simulate
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid
from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial
from cdp_ident.user_input import Limits

Input = tuple[Array, Array]
"""Times (n,) [s], and what drives the pendulum at them."""

_LATEST = 0.05
"""No encoder is later or earlier than this [s]."""
_Begin = Annotated[float, Limits(-1e3, 1e3, changeable=True)]


class MotionStream:
    """What the encoders would show of a motion, and its state; what was asked for long ago is forgotten.

    The integrator's steps are those of one long simulation whatever pieces are asked for, so nothing adds up.
    """

    def __init__(
        self,
        model: FittedModel,
        start: Array,
        trial: int | None = None,
        cart: Input | None = None,
        weights: tuple[Weight, ...] = (),
        torques: Input | None = None,
    ) -> None:
        """Begin at time 0.

        Args:
            model: gives the motion.
            start: (4,) state at time 0: theta1, theta2 [rad], omega1, omega2 [rad/s].
            trial: the number by which the model knows the trial, for what happened once in it.
            cart: the cart's acceleration (n,) [m/s^2], in between linear; None for a cart at rest.
            weights: that are clamped to the rods.
            torques: motors' torques (n, 2) in the joints [N m].
        """
        self.cart, self.torques = cart, torques
        """The inputs, from the time `now` on; others may take their places."""
        self._model, self._weights = model, weights
        self._trial = model.trial() if trial is None else trial
        weighted = model.motion.with_weights(model.values, weights)
        self._coefficients = model.motion.coefficients(weighted.values)
        self._effects = model.motion.acting(weighted.values, self._trial, weighted.carried)
        self._step, self._state = 0, np.ascontiguousarray(start, dtype=float)

    @property
    def now(self) -> float:
        """Time from which on inputs still matter [s]."""
        return self._step * DEFAULT_STEP

    def readings(self, times: Array) -> Array:
        """Return theta1 and theta2 (n, 2) [rad] as the encoders show them at ascending times (n,) [s].

        The first time must not be before the first one of the call before.
        """
        times = np.asarray(times, dtype=float)
        steps = int((float(times[0]) - _LATEST) / DEFAULT_STEP) - self._step
        if steps > 0:
            grid = TimeGrid(DEFAULT_STEP, steps, np.empty(0))
            u, drive = self._inputs(grid)
            problem = InitialValueProblem(self._coefficients, self._state, grid, u, self._effects, self.now, drive)
            self._state = motions([problem]).ends[0]
            self._step += steps
        since = times - self.now
        grid = TimeGrid.over(since)
        grid = replace(grid, steps=grid.steps + round(_LATEST / DEFAULT_STEP))  # an early encoder sees what comes then
        u, drive = self._inputs(grid)
        window = Window(
            self._trial, 0, self.now, since, np.empty((0, 2)), grid, u, self._state, drive, weights=self._weights
        )
        return self._model.motion.predict(self._model.values, self._state, window)

    def state(self, time: float) -> Array:
        """Return the rods' state (4,) at a time [s] from the first one on that was last asked for, without motors."""
        since = np.array([time - self.now])
        u, _ = self._inputs(TimeGrid.over(since))
        return simulate(self._coefficients, self._state, since, u, DEFAULT_STEP, self._effects, self.now)[0, :4]

    def _inputs(self, grid: TimeGrid) -> tuple[Array, Array | None]:
        """Return the cart's acceleration and the motors' torques at the half steps of a grid that begins now."""
        times = grid.half_step_times() + self.now
        u = np.interp(times, *self.cart) if self.cart else np.zeros(len(times))
        return u, grid.at_half_steps(*self.torques, self.now) if self.torques else None


class Frame(NamedTuple):
    """The pendulum at one instant; positions are of cart [m], inner and outer joint [rad], the outer one relative."""

    time: float
    """Since the motion's beginning [s]."""
    simulated: tuple[float, float, float]
    measured: tuple[float, float, float] | None = None

    @property
    def error(self) -> tuple[float, float] | None:
        """Simulated less measured position of inner and outer joint [rad]."""
        if self.measured is None:
            return None
        return self.simulated[1] - self.measured[1], self.simulated[2] - self.measured[2]


class Replay:
    """A trial, and the model's motion from the start that fits the trial's beginning best.

    With another model the whole motion is another: it has the start that fits best with that model.
    """

    def __init__(self, trial: Trial, model: FittedModel) -> None:
        self.duration = trial.duration
        """Its length [s]."""
        self._trial = trial
        cart = np.zeros_like(trial.time) if trial.cart is None else trial.cart
        # Through every sample; measured angles are as smooth as the motion, but for noise.
        self._measured = CubicSpline(trial.time, np.column_stack([cart, trial.theta]))
        acceleration = trial.cart_acceleration
        self._acceleration = None if acceleration is None else (trial.time, acceleration)
        self._torques = None if trial.torques is None else (trial.time, trial.torques)
        self.take_model(model, 0.0)

    def take_model(self, model: FittedModel, now: float) -> None:
        """Go on with another model; raises `IdentificationError` where its motion cannot be computed."""
        model = model.with_motors() if self._torques else model
        self._model, self._index = model, model.trial(self._trial.name)
        self._start = start_of(model.motion, model.values, self._trial, self._index, DEFAULT_WINDOW)
        self.restart()

    def restart(self) -> None:
        """Begin anew at time 0."""
        weights = self._trial.weights
        self._stream = MotionStream(self._model, self._start, self._index, self._acceleration, weights, self._torques)

    def frames(self, times: Array) -> list[Frame]:
        """Return the pendulum at ascending times (n,) [s], the first not before the first of the call before.

        Raises `SimulationError` where the motion leaves all bounds.
        """
        measured = self._measured(times)
        return frames(times, measured[:, 0], self._stream.readings(times), measured[:, 1:])


@dataclass(frozen=True)
class Start:
    """Where a free motion begins."""

    inner: _Begin = 2.0
    """Start of the inner joint [rad], 0 upright."""
    outer: _Begin = 0.0
    """Start of the outer joint [rad], relative to the inner rod."""
    inner_speed: _Begin = 0.0
    """Speed of the inner joint at the start [rad/s]."""
    outer_speed: _Begin = 0.0
    """Speed of the outer joint at the start [rad/s]."""

    @property
    def state(self) -> Array:
        """The state (4,): theta1, theta2 [rad], omega1, omega2 [rad/s]."""
        return np.array(
            [self.inner, self.inner + self.outer, self.inner_speed, self.inner_speed + self.outer_speed], dtype=float
        )


class Free:
    """The model's motion from a given start, the cart at rest."""

    duration = math.inf

    def __init__(self, start: Start, model: FittedModel) -> None:
        self._model, self._start = model, start
        self._stream, self._began = MotionStream(model, start.state), 0.0
        """The motion, and the time at which it began [s]."""

    def take_model(self, model: FittedModel, now: float) -> None:
        """Go on with another model from where it is now [s]; what was shown until then stays as it was."""
        self._stream, self._began = MotionStream(model, self._stream.state(now - self._began)), now
        self._model = model

    def restart(self) -> None:
        """Begin anew at time 0."""
        self._stream, self._began = MotionStream(self._model, self._start.state), 0.0

    def frames(self, times: Array) -> list[Frame]:
        """Return the pendulum at times (n,) [s]; see `Replay.frames`."""
        return frames(times, np.zeros(len(times)), self._stream.readings(times - self._began))


Scene = Replay | Free
"""A motion that is shown from time 0 on."""


def frames(times: Array, cart: Array, simulated: Array, measured: Array | None = None) -> list[Frame]:
    """Return frames of times (n,) [s], the cart's positions (n,) [m], and simulated and measured rods (n, 2) [rad].

    Raises:
        SimulationError: a simulated angle is not finite.
    """
    if not np.all(np.isfinite(simulated)):
        raise SimulationError(
            f"the simulated motion leaves all bounds before {times[-1]:.2f} s: no rig has such parameters, check them"
        )
    shown = _joints(cart, simulated)
    beside = [None] * len(times) if measured is None else _joints(cart, measured)
    return [Frame(*frame) for frame in zip(times.tolist(), shown, beside, strict=True)]


def _joints(cart: Array, theta: Array) -> list[tuple[float, float, float]]:
    columns = cart.tolist(), theta[:, 0].tolist(), (theta[:, 1] - theta[:, 0]).tolist()
    return list(zip(*columns, strict=True))
