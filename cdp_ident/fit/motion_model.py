# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The model as a fit sees it: the motion that follows from the numbers that are adjusted."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.model_unknowns import ModelUnknowns
from cdp_ident.fit.windows import Window
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.motors import MOTORS
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.motions import InitialValueProblem, motions
from cdp_ident.model.parameters import COEFFICIENTS, GROUPS, INVERSE_INERTIA, coefficients_of
from cdp_ident.model.time_grid import TimeGrid

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_TOGETHER = 8
"""Most windows that are simulated one after the other in one call of compiled code."""
LATEST = 0.05
"""No encoder is later or earlier than this [s]."""


@dataclass(frozen=True)
class MotionModel(ModelUnknowns):
    """The paper's model with any effects."""

    @cached_property
    def states(self) -> int:
        """Size of a state: theta1, theta2, omega1, omega2, and those that effects add."""
        return RODS_STATES + sum(active.effect.states for active in self.effects)

    @cached_property
    def start_penalty(self) -> Array:
        """(states,) what the square of each number of a window's initial state adds to the cost [rad^2]."""
        own = [1.0 / state.start_std**2 for active in self.effects for state in active.effect.law.states]
        return self.penalty_of_errors * np.array([0.0] * RODS_STATES + own)

    def initial_state(self, start: Array) -> Array:
        """Return an initial state of this model's size, given one of another model: what effects bring is zero."""
        if len(start) == self.states:
            return start
        return np.concatenate([start[:RODS_STATES], np.zeros(self.states - RODS_STATES)])

    def coefficients(self, values: Array) -> Array:
        """Return the model's coefficients (7,) under given values of the unknowns."""
        return coefficients_of(values[: len(GROUPS)], *self.constants(values))

    def acting(self, values: Array, trial: int, carried: float = 0.0) -> ActingEffects:
        """Return the effects in a trial, with the unknowns as directions: coefficients that are free, then parameters.

        The mass of the rods' weights in it, over the inertia about the cart's joint, is `carried` [1/m^2].
        """
        laid_out, fitted, _ = self._in_trial(trial)
        parameters = laid_out.values.copy()
        parameters[list(laid_out.parameters)] = values[fitted]
        return replace(laid_out, values=parameters, carried=carried)

    def _in_trial(self, trial: int) -> tuple[ActingEffects, Indices, Indices]:
        """Return the effects in a trial, the unknowns that their fitted parameters are, and which each direction is."""
        if trial not in self._layouts:
            there = [k for k, active in enumerate(self.effects) if active.trial in (None, trial)]
            chosen = [(e, [p.typical for p in e.parameters]) for e in (self.effects[k].effect for k in there)]
            own = np.array([at for k in there for at in range(*self.places(k).indices(len(self.names)))], dtype=int)
            of_motors = [*range(*self.places_of_motors.indices(len(self.names)))]
            if self.motors:
                chosen.insert(0, (MOTORS, [1.0 / self.mechanism.inertia, *(p.typical for p in self.of_motors)]))
                if self.inertia_free:
                    of_motors.insert(0, self.base_names.index(INVERSE_INERTIA.symbol))
            fitted = np.concatenate([of_motors, own]).astype(int)
            free = (*range(len(GROUPS)), *(COEFFICIENTS.index(name) for name in self._constants))
            laid_out = ActingEffects.of(chosen, self.mechanism.outer_length, fitted=True)
            acting = replace(
                laid_out,
                parameters=laid_out.parameters[len(laid_out.parameters) - len(fitted) :],
                coefficients=free,
            )
            unknowns = [*range(len(GROUPS)), *(self.base_names.index(name) for name in self._constants), *fitted]
            columns = np.concatenate([np.arange(self.states), self.states + np.array(unknowns)])
            self._layouts[trial] = acting, fitted, columns
        return self._layouts[trial]

    @cached_property
    def _layouts(self) -> dict[int, tuple[ActingEffects, Indices, Indices]]:
        """What `_in_trial` has laid out, by trial: it does not depend on the values of the unknowns."""
        return {}

    def columns_in(self, trial: int) -> Indices:
        """Return which unknown each direction of derivatives in a trial is, after those by the initial state."""
        return self._in_trial(trial)[2][self.states :] - self.states

    def states_in(self, values: Array, window: Window, times: Array) -> Array:
        """Return the states (k, states) in a window at times (k,) since its beginning [s]."""
        weighted = self.with_weights(values, window.weights) if window.weights else None
        of_trial = weighted.values if weighted else values
        acting = self.acting(of_trial, window.trial, weighted.carried if weighted else 0.0).without_directions()
        grid, start = replace(window.grid, place=times / window.grid.step), self.initial_state(window.start)
        problem = InitialValueProblem(
            self.coefficients(of_trial), start, grid, window.u, acting, window.begin, window.drive
        )
        return motions([problem], shown=False).states

    def predict(self, values: Array, start: Array, window: Window) -> Array:
        """Return the angles (n, 2) that the encoders show in a window [rad].

        Args:
            values: (unknowns,) values of the unknowns.
            start: state at the window's beginning.
            window: gives the trial and the times.
        """
        return self._predict_run(values, [start], [window], derive=False)[0]

    def predict_together(
        self, values: Array, starts: Sequence[Array], windows: Sequence[Window]
    ) -> tuple[Array, Array, Indices]:
        """Return what `predict` does of each of several windows, their samples end to end: see `blocks`.

        The second array (n, 2, states) has the derivatives by each window's initial state; the third one says where
        each window's samples begin, and the last one's end.
        """
        thetas, by_starts, bounds = list[Array](), list[Array](), [0]
        for run in _alike(windows):
            theta, by_start, of_run = self._predict_run(values, starts[run], windows[run], derive=True)
            thetas.append(theta)
            by_starts.append(by_start)
            bounds += (bounds[-1] + of_run[1:]).tolist()
        return np.concatenate(thetas), np.concatenate(by_starts), np.array(bounds)

    def _predict_run(
        self, values: Array, starts: Sequence[Array], windows: Sequence[Window], derive: bool
    ) -> tuple[Array, Array, Indices]:
        """Do the same for windows of one trial with the same weights."""
        trial = windows[0].trial
        weighted = self.with_weights(values, windows[0].weights)
        acting = self.acting(weighted.values, trial, weighted.carried).without_directions()
        coefficients = self.coefficients(weighted.values)
        found = motions(
            [
                InitialValueProblem(coefficients, self.initial_state(start), grid, u, acting, window.begin, drive)
                for start, window in zip(starts, windows, strict=True)
                for grid, u, drive in [self._times(window)]
            ],
            derive=derive,
        )
        # Both absolute angles contain the inner encoder's.
        place = self.zero_places(trial)
        of_zeros = self.by_zeros @ values[place] if place.start < place.stop else 0.0
        theta = np.cumsum(found.readings + of_zeros, axis=1)
        return theta, np.cumsum(found.by, axis=1) if derive else np.empty((0, 2, 0)), found.bounds

    @cached_property
    def _earliest(self) -> float:
        """By how much an encoder may be read before its time [s]."""
        return LATEST if any(active.effect.law.lateness for active in self.effects) else 0.0

    def _times(self, window: Window) -> tuple[TimeGrid, Array, Array | None]:
        """Return a window's steps, up to what an early encoder sees, and the inputs at their halves."""
        if not self._earliest:
            return window.grid, window.u, window.drive
        grid, drive = window.grid.extended(self._earliest), window.drive
        more = (0, 2 * grid.steps + 1 - len(window.u))
        drive = None if drive is None else np.pad(drive, (more, (0, 0)), mode="edge")
        return grid, np.pad(window.u, more, mode="edge"), drive

    def blocks(self, windows: Sequence[Window]) -> list[slice]:
        """Return which windows are predicted together: neighbours of one trial, so that cores can share them out."""
        return [piece for part in _alike(windows) for piece in _divided(part, _TOGETHER)]


def _alike(windows: Sequence[Window]) -> list[slice]:
    """Return which neighbours are of one trial, with the same weights."""
    first, runs = 0, []
    for _, run in groupby(windows, key=lambda window: (window.trial, window.weights)):
        end = first + sum(1 for _ in run)
        runs.append(slice(first, end))
        first = end
    return runs


def _divided(part: slice, most: int) -> list[slice]:
    """Divide neighbours into blocks of so many at most, equally large if possible."""
    first, size = part.start, part.stop - part.start
    count = -(-size // most)
    return [slice(first + size * k // count, first + size * (k + 1) // count) for k in range(count)]
