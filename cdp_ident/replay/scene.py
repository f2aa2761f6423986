# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can be shown: a motion of the model alone, or beside a recorded trial."""

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.diagnosis.evaluation import start_of
from cdp_ident.errors import SimulationError
from cdp_ident.fit.windows import DEFAULT_WINDOW
from cdp_ident.replay.stream import MotionStream
from cdp_ident.trial.trial import Trial
from cdp_ident.user_input import Limits

Array = npt.NDArray[np.float64]
_Begin = Annotated[float, Limits(-1e3, 1e3, changeable=True)]


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


class Scene(Protocol):
    """A motion that is shown from time 0 on."""

    duration: float
    """Its length [s], infinite where it has no end."""

    def take_model(self, model: FittedModel, now: float) -> None:
        """Go on with another model; what was shown until now [s] stays as it was.

        Raises `IdentificationError` where the model's motion cannot be computed.
        """

    def restart(self) -> None:
        """Begin anew at time 0."""

    def frames(self, times: Array) -> list[Frame]:
        """Return the pendulum at ascending times [s], the first not before the first of the call before.

        Raises `SimulationError` where the motion leaves all bounds.
        """


class Replay:
    """A trial, and the model's motion from the start that fits the trial's beginning best.

    With another model the whole motion is another: it has the start that fits best with that model.
    """

    def __init__(self, trial: Trial, model: FittedModel) -> None:
        self.duration = trial.duration
        self._trial = trial
        cart = np.zeros_like(trial.time) if trial.cart is None else trial.cart
        # Through every sample; measured angles are as smooth as the motion, but for noise.
        self._measured = CubicSpline(trial.time, np.column_stack([cart, trial.theta]))
        acceleration = trial.cart_acceleration
        self._acceleration = None if acceleration is None else (trial.time, acceleration)
        self._torques = None if trial.torques is None else (trial.time, trial.torques)
        self.take_model(model, 0.0)

    def take_model(self, model: FittedModel, now: float) -> None:
        """See `Scene`."""
        model = model.with_motors() if self._torques else model
        self._model, self._index = model, model.trial(self._trial.name)
        self._start = start_of(model.motion, model.values, self._trial, self._index, DEFAULT_WINDOW)
        self.restart()

    def restart(self) -> None:
        """See `Scene`."""
        trial = self._trial
        self._stream = MotionStream(
            self._model, self._start, self._index, self._acceleration, trial.weights, self._torques
        )

    def frames(self, times: Array) -> list[Frame]:
        """See `Scene`."""
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
    """The model's motion from a given start, the cart at rest. With another model it goes on from where it is."""

    duration = math.inf

    def __init__(self, start: Start, model: FittedModel) -> None:
        self._model, self._start = model, start
        self._stream, self._began = MotionStream(model, start.state), 0.0
        """The motion, and the time at which it began [s]."""

    def take_model(self, model: FittedModel, now: float) -> None:
        """See `Scene`."""
        self._stream, self._began = MotionStream(model, self._stream.state(now - self._began)), now
        self._model = model

    def restart(self) -> None:
        """See `Scene`."""
        self._stream, self._began = MotionStream(self._model, self._start.state), 0.0

    def frames(self, times: Array) -> list[Frame]:
        """See `Scene`."""
        return frames(times, np.zeros(len(times)), self._stream.readings(times - self._began))


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
