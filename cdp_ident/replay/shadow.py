# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The model's motion beside a live rig: from each release on, until the pendulum rests or is caught.

A measured cart is an input, and so are torques of motors in the joints where they are said to drive.
"""

from bisect import bisect_left
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from enum import Enum

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.errors import CdpIdentError
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.windows import FEWEST_SAMPLES, beginning_of
from cdp_ident.model.time_grid import DEFAULT_STEP
from cdp_ident.replay.scene import Frame, Input, MotionStream, frames
from cdp_ident.rig.recording.detector import EndDetector, ReleaseDetector, SlidingRange, TrialLimits
from cdp_ident.rig.recording.facts import Position
from cdp_ident.trial.joints import in_radians, model_angles
from cdp_ident.trial.kinematics import local_motion
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.trial import Trial

DEFAULT_LEAD = 0.5
"""How much of the motion after a release the start is fitted to [s]."""
_BEGUN = 0.5
"""What drives the pendulum from where it hangs has moved so lately [s]."""
_AROUND = 0.03
"""Samples of the cart this near make its speed, and speeds its acceleration [s]."""
_BEFORE = 0.1
"""So much before the first input that matters tells of it, too [s]."""


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
            options: what the joints' positions mean, and the input: of `none` the cart may not move farther than
                `cart_limit`; what the `cart` or motors in the `joints` drive may begin to move where it hangs.
            limits: what counts as held, let go and at rest.
            lead: how much of the motion after a release the start is fitted to [s].
        """
        self.phase = Phase.WAITING
        self.why = "none was seen yet"
        """In words, why it is in this phase."""
        self._options, self._limits, self._lead = options or TrialOptions(), limits or TrialLimits(), lead
        self._last_ns: int | None = None
        self._use(model)
        self._stream = MotionStream(self._model, np.zeros(4))
        self._stream.readings(np.zeros(1))  # compiles, before the rig moves
        self._look_out()

    def reset(self) -> None:
        """Wait for the next release."""
        self._look_out()
        self._wait("it was asked to")

    def _look_out(self) -> None:
        self._release = ReleaseDetector(self._limits)
        self._leaving = ReleaseDetector(replace(self._limits, away_limit=0.0))
        """It may hang where it rests."""
        self._cart_range = SlidingRange(_BEGUN)

    def take_model(self, model: FittedModel) -> None:
        """Go on with another model, from the start that fits best with it; raises as `take` does."""
        self._use(model)
        if self.phase is Phase.BESIDE:
            self._begin_beside()

    def _use(self, model: FittedModel) -> None:
        self._model = model.with_motors() if self._options.input == "joints" else model

    def take(self, position: Position) -> list[tuple[int, Frame]]:
        """Take the rig's next position; return the frames to show now and their stamps [ns].

        The positions that the start was fitted to are shown as soon as it is. Raises `CdpIdentError` where the model's
        motion cannot be computed or leaves all bounds; then it waits for the next release.
        """
        if self._last_ns is not None and position.stamp_ns <= self._last_ns:
            if position.stamp_ns == self._last_ns:
                return []
            self._look_out()
            self._wait("the rig's time went back")
        self._last_ns = position.stamp_ns
        if self._options.input == "joints" and position.torques is None:
            self._wait("the joints have no efforts, which are said to be the input")
            return []
        angles = in_radians(np.array([[position.inner, position.outer]]), self._options)
        theta = model_angles(angles, self._options)[0]
        inner, outer = float(theta[0]), float(theta[1] - theta[0])
        cart = 0.0 if position.cart is None else self._options.cart_sign * position.cart
        moved_lately = self._cart_range.update(position.stamp_ns, cart)
        by_cart = self._options.input == "cart" and moved_lately > self._options.cart_limit
        is_released, began_to_move = (
            of.update(position.stamp_ns, inner, outer) for of in (self._release, self._leaving)
        )
        if is_released:
            self._begin(position, "the pendulum was let go")
        elif began_to_move and (by_cart or self._options.input == "joints"):
            self._begin(position, "what drives the pendulum began to move it")
        if self.phase is Phase.WAITING or self._ended(position, inner, outer):
            return []
        time = (position.stamp_ns - self._released_ns) * 1e-9
        signs = self._options.inner_sign, self._options.outer_sign
        self._times.append(time)
        self._seen.append((cart, *theta, *np.multiply(signs, position.torques or (0.0, 0.0))))
        if self.phase is Phase.BESIDE:
            return self._frames(len(self._times) - 1)
        if time < self._lead or len(self._times) < FEWEST_SAMPLES:
            return []
        self._looked_at = len(self._times)
        self._begin_beside()
        return self._frames(0)

    def _begin(self, position: Position, why: str) -> None:
        self.phase, self.why = Phase.LOOKING, why
        self._released_ns = position.stamp_ns
        self._end = EndDetector(self._limits, position.stamp_ns)
        self._cart = position.cart
        self._times: list[float] = []
        self._seen: list[tuple[float, ...]] = []

    def _begin_beside(self) -> None:
        """Find the start that fits what was seen after the release."""
        seen = np.array(self._seen[: self._looked_at])
        torques = seen[:, 3:] if self._model.motion.motors else None
        trial = Trial("", np.array(self._times[: len(seen)]), seen[:, 1:3], torques=torques)
        window = beginning_of(trial, self._model.trial(), np.inf)
        if cart := _acceleration(trial.time, seen[:, 0]):
            window = replace(window, u=np.interp(window.grid.half_step_times(), *cart))
        with self._waiting_after_errors():
            found = fit_initial_states(self._model.motion, self._model.values, [window])
        self._stream, self.phase = MotionStream(self._model, found.windows[0].start), Phase.BESIDE

    def _ended(self, position: Position, inner: float, outer: float) -> bool:
        """Notice that the motion is no longer that of a pendulum left to itself."""
        moved = 0.0 if self._cart is None or position.cart is None else abs(position.cart - self._cart)
        if end := self._end.update(position.stamp_ns, inner, outer):
            self._wait(end.value)
        elif self._options.input == "none" and moved > self._options.cart_limit:
            self._wait(f"the cart moved by more than {self._options.cart_limit:g} m")
        return self.phase is Phase.WAITING

    def _wait(self, why: str) -> None:
        self.phase, self.why = Phase.WAITING, why

    @contextmanager
    def _waiting_after_errors(self) -> Iterator[None]:
        try:
            yield
        except CdpIdentError as error:
            self._wait(str(error))
            raise

    def _frames(self, first: int) -> list[tuple[int, Frame]]:
        """Return the frames from a sample on."""
        begin = bisect_left(self._times, self._stream.now - _BEFORE)
        known, inputs = np.array(self._times[begin:]), np.array(self._seen[begin:])
        torques = (known, inputs[:, 3:]) if self._model.motion.motors else None
        self._stream.cart, self._stream.torques = _acceleration(known, inputs[:, 0]), torques
        times, seen = np.array(self._times[first:]), np.array(self._seen[first:])
        stamps = (self._released_ns + np.round(times * 1e9).astype(np.int64)).tolist()
        with self._waiting_after_errors():
            shown = frames(times, seen[:, 0], self._stream.readings(times), seen[:, 1:3])
            return list(zip(stamps, shown, strict=True))


def _acceleration(times: Array, cart: Array) -> Input | None:
    """Return the cart's acceleration, given its positions; None where it is at rest."""
    if np.ptp(cart) == 0.0 or len(times) < FEWEST_SAMPLES:
        return None
    at = np.linspace(times[0], times[-1], max(FEWEST_SAMPLES, round(2.0 * np.ptp(times) / DEFAULT_STEP)))
    _, speeds = local_motion(times, cart[:, None], at, _AROUND)
    return at, local_motion(at, speeds, at, _AROUND)[1][:, 0]
