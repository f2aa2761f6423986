# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The model's motion beside a live rig: from each release on, until the pendulum rests, is caught or is pushed."""

from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum

import numpy as np
import numpy.typing as npt

from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.diagnosis.evaluation import start_of
from cdp_ident.errors import CdpIdentError
from cdp_ident.fit.windows import FEWEST_SAMPLES
from cdp_ident.replay.scene import Frame, frames
from cdp_ident.replay.stream import MotionStream
from cdp_ident.rig.recording.detector import EndDetector, ReleaseDetector, TrialLimits
from cdp_ident.rig.recording.facts import Position
from cdp_ident.trial.joints import in_radians, model_angles
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

DEFAULT_LEAD = 0.5
"""How much of the motion after a release the start is fitted to [s]."""


class Phase(Enum):
    """What a shadow does."""

    WAITING = "waits for a release"
    LOOKING = "looks at the motion after a release"
    BESIDE = "runs beside the rig"


class Shadow:
    """Follows a rig sample by sample."""

    def __init__(
        self,
        model: FittedModel,
        options: TrialOptions | None = None,
        limits: TrialLimits | None = None,
        lead: float = DEFAULT_LEAD,
    ) -> None:
        """Wait for the first release.

        Args:
            model: gives the motion.
            options: what the joints' positions mean, and how far the cart may move (`cart_limit`).
            limits: what counts as held, let go and at rest.
            lead: how much of the motion after a release the start is fitted to [s].
        """
        self.phase = Phase.WAITING
        self.why = "none was seen yet"
        """In words, why it is in this phase."""
        self._model, self._options, self._limits, self._lead = (
            model, options or TrialOptions(), limits or TrialLimits(), lead,
        )  # fmt: skip
        self._last_ns: int | None = None
        self._stream = MotionStream(model, np.zeros(4))
        self._stream.readings(np.zeros(1))  # compiles, before the rig moves
        self._release = ReleaseDetector(self._limits)

    def reset(self) -> None:
        """Wait for the next release."""
        self._release = ReleaseDetector(self._limits)
        self._wait("it was asked to")

    def take_model(self, model: FittedModel) -> None:
        """Go on with another model, from the start that fits best with it; raises as `take` does."""
        self._model = model
        if self.phase is Phase.BESIDE:
            self._begin_beside()

    def take(self, position: Position) -> list[tuple[int, Frame]]:
        """Take the rig's next position; return the frames to show now and their stamps [ns].

        The positions that the start was fitted to are shown as soon as it is. Raises `CdpIdentError` where the model's
        motion cannot be computed or leaves all bounds; then it waits for the next release.
        """
        if self._last_ns is not None and position.stamp_ns <= self._last_ns:
            if position.stamp_ns == self._last_ns:
                return []
            self._release = ReleaseDetector(self._limits)
            self._wait("the rig's time went back")
        self._last_ns = position.stamp_ns
        angles = in_radians(np.array([[position.inner, position.outer]]), self._options)
        theta = model_angles(angles, self._options)[0]
        inner, outer = float(theta[0]), float(theta[1] - theta[0])
        if self._release.update(position.stamp_ns, inner, outer):
            self._begin(position)
        if self.phase is Phase.WAITING or self._ended(position, inner, outer):
            return []
        cart = 0.0 if position.cart is None else self._options.cart_sign * position.cart
        time = (position.stamp_ns - self._released_ns) * 1e-9
        if self.phase is Phase.BESIDE:
            return self._frames(np.array([time]), np.array([cart]), theta[None])
        self._times.append(time)
        self._seen.append((cart, *theta))
        if time < self._lead or len(self._times) < FEWEST_SAMPLES:
            return []
        self._begin_beside()
        seen = np.array(self._seen)
        return self._frames(np.array(self._times), seen[:, 0], seen[:, 1:])

    def _begin(self, position: Position) -> None:
        self.phase, self.why = Phase.LOOKING, "the pendulum was let go"
        self._released_ns = position.stamp_ns
        self._end = EndDetector(self._limits, position.stamp_ns)
        self._cart = position.cart
        self._times: list[float] = []
        self._seen: list[tuple[float, ...]] = []

    def _begin_beside(self) -> None:
        """Find the start that fits what was seen after the release."""
        trial = Trial("", np.array(self._times), np.array(self._seen)[:, 1:])
        with self._waiting_after_errors():
            start = start_of(self._model.motion, self._model.values, trial, self._model.trial(), np.inf)
        self._stream, self.phase = MotionStream(self._model, start), Phase.BESIDE

    def _ended(self, position: Position, inner: float, outer: float) -> bool:
        """Notice that the motion is no longer that of a pendulum left to itself."""
        if end := self._end.update(position.stamp_ns, inner, outer):
            self._wait(end.value)
        elif self._cart_moved(position) > self._options.cart_limit:
            self._wait(f"the cart moved by more than {self._options.cart_limit:g} m")
        return self.phase is Phase.WAITING

    def _cart_moved(self, position: Position) -> float:
        """Return how far the cart is from where it was at the release [m], 0 where it is not measured."""
        return 0.0 if self._cart is None or position.cart is None else abs(position.cart - self._cart)

    def _wait(self, why: str) -> None:
        self.phase, self.why = Phase.WAITING, why

    @contextmanager
    def _waiting_after_errors(self) -> Iterator[None]:
        try:
            yield
        except CdpIdentError as error:
            self._wait(str(error))
            raise

    def _frames(self, times: Array, cart: Array, measured: Array) -> list[tuple[int, Frame]]:
        stamps = (self._released_ns + np.round(times * 1e9).astype(np.int64)).tolist()
        with self._waiting_after_errors():
            return list(zip(stamps, frames(times, cart, self._stream.readings(times), measured), strict=True))
