"""Initial states fitted alone: with all values held, each window is a fit of its own.

Each has its own damping (Marquardt, 1963) and is left as it is once it has converged: no window is simulated again for
another one's sake, and none is kept from its minimum by one whose joint sticks now here and now there.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.initial_states import inverse_factor
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.normal_equations import (
    DAMPING_FACTOR,
    FIRST_DAMPING,
    LARGEST_DAMPING,
    LEAST_DAMPING,
    NormalEquations,
    any_beyond,
    damp,
    outlier_limit,
)
from cdp_ident.fit.windows import Window, split

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]

MOST_FOR_STARTS = 25
"""The most iterations where only initial states are fitted: they need few, unless the held values do not fit."""
_NOTHING = np.empty(0)


def fit_each_window(model: MotionModel, values: Array, windows: Sequence[Window], tolerance: float) -> "HeldValues":
    """Fit the initial state of each window by least squares.

    Args:
        model: gives the motion.
        values: (unknowns,) the values that are held.
        windows: what to fit, with initial guesses of their initial states.
        tolerance: a window's fit has converged when its cost decreases by less than this share in an iteration.

    Raises:
        IdentificationError: a window's motion cannot be computed from its initial guess.
    """
    fits, limit = HeldValues(model, values, windows), np.inf
    left: Indices = np.arange(len(windows))
    while fits.iterations < MOST_FOR_STARTS:
        if not len(left):
            # All have ended under the present limit for outliers: are there residuals beyond a lower one?
            if limit < np.inf:
                break
            limit = outlier_limit(fits.residuals)
            left = np.array([k for k, residual in enumerate(fits.residuals) if any_beyond(residual, limit)], dtype=int)
            if not len(left):
                break
            fits.reweigh(left, limit)
        left = fits.iterate(left, limit, tolerance)
    fits.find_again(tolerance)
    return fits


class HeldValues:
    """Windows and the initial states that they have so far, under values that are held."""

    def __init__(self, model: MotionModel, values: Array, windows: Sequence[Window]):
        """Begin with the initial states that the windows have.

        Args:
            model: gives the motion.
            values: (unknowns,) their values.
            windows: what is fitted, each for itself.
        """
        self._model, self._values, self._windows = model, values, windows
        count, states = len(windows), model.states
        self.starts = np.array([model.initial_state(window.start) for window in windows])
        self.residuals, self.sensitivities, self.weights = ([_NOTHING] * count for _ in range(3))
        self.costs, self.converged = np.empty(count), np.zeros(count, dtype=bool)
        self._normal, self._right = np.empty((count, states, states)), np.empty((count, states))
        self._damping = np.full(count, FIRST_DAMPING)
        self._known = np.array([window.start_known for window in windows])
        self.iterations, self.simulated = 0, 0
        """Steps made, and windows simulated in all of them."""
        self.reweigh(np.arange(count), np.inf)
        if not np.all(np.isfinite(self.costs)):
            raise IdentificationError("the model's motion cannot be computed from the parameters to begin with")

    def reweigh(self, chosen: Indices, limit: float) -> None:
        """Let residuals of some windows beyond a limit [rad] cost their absolute value only."""
        self.converged[chosen] = False
        self._move(chosen, self.starts[chosen], np.full(len(chosen), np.inf), limit)

    def iterate(self, chosen: Indices, limit: float, tolerance: float) -> Indices:
        """Make a step in each of some windows, and return those that have not come to their end."""
        self.iterations += 1
        matrices, right, damping = self._normal[chosen], self._right[chosen], self._damping[chosen]
        damp(matrices, self._model.states, damping[:, None])
        factor = np.where(self._known[chosen, None, None], 0.0, inverse_factor(matrices))
        change = (factor @ (factor.transpose(0, 2, 1) @ right[:, :, None]))[:, :, 0]
        expected = np.sum(change * right, axis=1)
        is_small = expected <= tolerance * self.costs[chosen]
        near = is_small & (damping <= FIRST_DAMPING)  # not small because it is damped
        self._move_near(chosen[near], change[near], expected[near])
        others, before = chosen[~near], self.costs[chosen[~near]]
        is_better = self._move(others, self.starts[others] + change[~near], before, limit)
        # At the minimum, rounding keeps the cost from decreasing: the fit has converged, too.
        gained_little = np.where(
            is_better, before - self.costs[others] <= tolerance * self.costs[others], is_small[~near]
        )
        self.converged[chosen[near]], self.converged[others] = True, gained_little
        self._damping[others] = np.where(
            is_better,
            np.maximum(self._damping[others] / DAMPING_FACTOR, LEAST_DAMPING),
            self._damping[others] * DAMPING_FACTOR,
        )
        return others[~gained_little & (self._damping[others] < LARGEST_DAMPING)]

    def find_again(self, tolerance: float) -> None:
        """Begin windows that have not converged anew, from what their first half shows: it is less chaotic.

        Each keeps the better of its two initial states.
        """
        lost = [k for k in np.flatnonzero(~self.converged) if len(split(self._windows[k], 2)) > 1]
        if not lost:
            return
        halves = [split(self._windows[k], 2)[0] for k in lost]
        begun = fit_each_window(self._model, self._values, halves, tolerance)
        others = HeldValues(
            self._model,
            self._values,
            [replace(self._windows[k], start=start) for k, start in zip(lost, begun.starts, strict=True)],
        )
        left: Indices = np.arange(len(lost))
        while len(left) and others.iterations < MOST_FOR_STARTS:
            left = others.iterate(left, np.inf, tolerance)
        for place, k in enumerate(lost):
            if others.costs[place] < self.costs[k]:
                for own, found in zip(self._of_windows, others._of_windows, strict=True):
                    own[k] = found[place]

    @property
    def _of_windows(self) -> tuple[Any, ...]:
        """What there is of each window."""
        return (
            self.starts, self.residuals, self.sensitivities, self.weights, self.costs, self.converged, self._normal,
            self._right, self._damping,
        )  # fmt: skip

    def _move_near(self, chosen: Indices, change: Array, expected: Array) -> None:
        """Move initial states by small steps, in which residuals are linear: no simulation is needed."""
        self.starts[chosen] += change
        self.costs[chosen] -= expected
        for window, of_window in zip(chosen, change, strict=True):
            self.residuals[window] = self.residuals[window] - self.sensitivities[window] @ of_window

    def _move(self, chosen: Indices, starts: Array, largest: Array, limit: float) -> Flags:
        """Move initial states (chosen, states) where that costs no more than `largest`, and return where."""
        if not len(chosen):
            return np.empty(0, dtype=bool)
        self.simulated += len(chosen)
        windows = [self._windows[window] for window in chosen]
        problem = NormalEquations(self._model, windows, np.empty(0, dtype=np.int64), self._values)
        point, costs = problem.evaluate_each(_NOTHING, list(starts), limit)
        is_better = costs <= largest
        normal = np.concatenate([matrices for _, matrices in point.normal.parts()])
        for place in np.flatnonzero(is_better):
            window = chosen[place]
            self.starts[window], self.costs[window] = starts[place], costs[place]
            self._normal[window], self._right[window] = normal[place], point.right[place]
            self.residuals[window], self.weights[window] = point.residuals[place], point.weights[place]
            self.sensitivities[window] = point.sensitivities[place]
        return np.asarray(is_better)
