# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a model follows windows of the motion: its values are held, each window's initial state is fitted.

It measures how well a model predicts. Each window is a least-squares problem of its own, with its own damping
(Marquardt, 1963), and is left as it is once it has converged: no window is simulated again for another one's sake, and
none is kept from its minimum by one whose joint sticks now here and now there.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import FEWEST_SAMPLES, Window
from cdp_ident.machine.parallel import parallel_for
from cdp_ident.trial.differences import MEDIAN_OF_SIZE
from cdp_ident.trial.kinematics import local_motion

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]

OUTLIER = 6.0
"""Residuals beyond so many robust standard deviations lose weight (Huber, Robust Statistics, 1981)."""
_TOLERANCE = 1e-6
"""A window's fit has converged when its cost decreases by less than this share in a step."""
_MOST_STEPS = 25
"""Steps of a window: few are needed, unless the held values do not fit."""
_MOST_PASSES = 5
"""How often zeros of encoders and initial states are fitted in turn."""
_FIRST_DAMPING, _LEAST_DAMPING, _LARGEST_DAMPING = 1e-3, 1e-12, 1e8
_DAMPING_FACTOR = 4.0
"""By which the damping changes after each step: down after a good one, up after a bad one."""
_HIDDEN = 1e-3
"""A part of an initial state is damped as if it moved the angles by at least this share of what another one does: a
joint that stops at once hides the speed that it begins with."""
_CUT_OFF = 1e-13
"""Eigenvalue of a scaled matrix, as a share of the largest, below which a direction counts as undetermined."""
_ASTRAY = 1.5
"""A window is looked at whose error is so many times the median of all windows' …"""
_BETTER = 0.8
"""… and has a better initial state if that leaves at most this share of its squared error."""


@dataclass(frozen=True)
class Fit:
    """The model's motion over windows, from the initial states that fit them best."""

    model: MotionModel
    values: Array
    """(unknowns,) that are held, in the order of `model.names`."""
    windows: tuple[Window, ...]
    """The windows, with their fitted initial states."""
    residuals: tuple[Array, ...]
    """(n, 2) measured minus simulated angles of each window, whitened [rad]."""

    @cached_property
    def errors(self) -> tuple[Array, ...]:
        """(n, 2) measured minus simulated theta1 and theta2 of each window [rad]."""
        return tuple(w.angles_of(residual) for w, residual in zip(self.windows, self.residuals, strict=True))

    def rmse(self, angle: int | None = None) -> float:
        """Root mean square error of one angle (0: theta1, 1: theta2) or of both together [rad].

        Samples in which both joints rest count by their weights.
        """
        columns = slice(None) if angle is None else slice(angle, angle + 1)
        counts = [np.max(window.counts, axis=1) for window in self.windows]
        squared = [of @ np.mean(error[:, columns] ** 2, axis=1) for of, error in zip(counts, self.errors, strict=True)]
        return float(np.sqrt(sum(squared) / sum(map(np.sum, counts))))


def fit_initial_states(model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit:
    """Fit the windows' initial states, with the zeros of trials that the model does not know, where it has such.

    Args:
        model: gives the motion.
        values: (unknowns,) that are held.
        windows: what to follow, with initial guesses of their initial states.

    Raises:
        IdentificationError: there is no window, or the motion cannot be computed from the first initial states.
    """
    if not windows:
        raise IdentificationError("there is nothing to fit: no window of any trial has enough samples")
    new = sorted({window.trial for window in windows} - set(model.zeros)) if model.zeros else []
    model, values = model.with_zeros(values, new) if new else (model, values)
    for _ in range(_MOST_PASSES if new else 1):
        found = _fit_each(model, values, windows)
        windows = [replace(w, start=start) for w, start in zip(windows, found.starts, strict=True)]
        before = values
        values = found.with_zeros(new)
        if np.array_equal(before, values):
            break
    return Fit(model, before, tuple(windows), tuple(found.residuals))


def _fit_each(model: MotionModel, values: Array, windows: Sequence[Window]) -> "_HeldValues":
    fits, limit = _HeldValues(model, values, windows), np.inf
    left: Indices = np.arange(len(windows))
    for _ in range(_MOST_STEPS):
        if not len(left):
            # All have ended under the present limit for outliers: are there residuals beyond a lower one?
            if limit < np.inf:
                break
            limit = _outlier_limit(fits.residuals)
            left = np.array([k for k, r in enumerate(fits.residuals) if np.any(np.abs(r) > limit)], dtype=int)
            if not len(left):
                break
            fits.reweigh(left, limit)
        left = fits.iterate(left, limit)
    fits.begin_anew()
    return fits


def _outlier_limit(residuals: Sequence[Array]) -> float:
    """Return the residual [rad] beyond which they lose weight, by a robust standard deviation: their median size."""
    median = float(np.median(np.abs(np.concatenate([r.ravel() for r in residuals]))))
    return max(OUTLIER * median / MEDIAN_OF_SIZE, np.finfo(float).tiny)


class _HeldValues:
    """Windows and the initial states that they have so far."""

    def __init__(self, model: MotionModel, values: Array, windows: Sequence[Window]):
        self._model, self._values, self._windows = model, values, windows
        count, states = len(windows), model.states
        self.starts = np.array([model.initial_state(window.start) for window in windows])
        self.residuals, self._slopes = [np.empty(0)] * count, [np.empty(0)] * count
        self.costs, self.converged = np.empty(count), np.zeros(count, dtype=bool)
        self._normal, self._right = np.empty((count, states, states)), np.empty((count, states))
        self._damping = np.full(count, _FIRST_DAMPING)
        self.reweigh(np.arange(count), np.inf)
        if not np.all(np.isfinite(self.costs)):
            raise IdentificationError("the model's motion cannot be computed from the parameters to begin with")

    def reweigh(self, chosen: Indices, limit: float) -> None:
        """Let residuals of some windows beyond a limit [rad] cost their absolute value only."""
        self.converged[chosen] = False
        self._move(chosen, self.starts[chosen], np.full(len(chosen), np.inf), limit)

    def iterate(self, chosen: Indices, limit: float) -> Indices:
        """Make a step in each of some windows, and return those that have not come to their end."""
        matrices, right, damping = self._normal[chosen], self._right[chosen], self._damping[chosen]
        change = _damped_step(matrices, right, damping)
        expected = np.sum(change * right, axis=1)
        is_small = expected <= _TOLERANCE * self.costs[chosen]
        near = is_small & (damping <= _FIRST_DAMPING)  # not small because it is damped
        self._move_near(chosen[near], change[near], expected[near])
        others, before = chosen[~near], self.costs[chosen[~near]]
        is_better = self._move(others, self.starts[others] + change[~near], before, limit)
        # At the minimum, rounding keeps the cost from decreasing: the fit has converged, too.
        gained_little = np.where(
            is_better, before - self.costs[others] <= _TOLERANCE * self.costs[others], is_small[~near]
        )
        self.converged[chosen[near]], self.converged[others] = True, gained_little
        better, worse = self._damping[others] / _DAMPING_FACTOR, self._damping[others] * _DAMPING_FACTOR
        self._damping[others] = np.where(is_better, np.maximum(better, _LEAST_DAMPING), worse)
        return others[~gained_little & (self._damping[others] < _LARGEST_DAMPING)]

    def begin_anew(self) -> None:
        """Begin windows anew that have not converged, or whose error is far above the others'.

        What the first half of a window shows is less chaotic. Where a joint sticks, the motion depends on its initial
        state by jumps, across which least squares do not find, as they follow derivatives: a rod that is let go rests
        where it is, or slides to another place and rests there. So a window begins from its own samples, too, and at
        rest. Each keeps the best of its initial states.
        """
        errors = [float(np.sum(r**2)) / w.independent for r, w in zip(self.residuals, self._windows, strict=True)]
        astray = (np.array(errors) > _ASTRAY**2 * np.median(errors)) & self.converged
        halves = {int(k): len(self._windows[k].theta) // 2 for k in np.flatnonzero(~self.converged)}
        halves = {k: half for k, half in halves.items() if half >= FEWEST_SAMPLES}
        places, starts = list(halves), list[Array]()
        if halves:
            shorter = [self._windows[k].shortened(half) for k, half in halves.items()]
            starts += list(_fit_each(self._model, self._values, shorter).starts)
        for k in np.flatnonzero(astray):
            places += [int(k)] * 2
            starts += self._others(int(k))
        windows = [replace(self._windows[k], start=start) for k, start in zip(places, starts, strict=True)]
        if not windows:
            return
        try:
            others = _HeldValues(self._model, self._values, windows)
        except IdentificationError:
            return
        left: Indices = np.arange(len(windows))
        for _ in range(_MOST_STEPS):
            left = others.iterate(left, np.inf) if len(left) else left
        for place, k in enumerate(places):
            if others.costs[place] < (_BETTER if astray[k] else 1.0) * self.costs[k]:
                self.starts[k], self.costs[k] = others.starts[place], others.costs[place]
                self.residuals[k], self._slopes[k] = others.residuals[place], others._slopes[place]

    def _others(self, k: int) -> list[Array]:
        """Return initial states (states,): as its first samples show it, and at rest where the rods mostly are."""
        window, own = self._windows[k], self.starts[k]
        off = (window.theta - window.angles_of(self.residuals[k]))[0] - own[:2]
        angles, speeds = local_motion(window.time, window.theta, np.zeros(1), window.half_width)
        seen, at_rest = own.copy(), own.copy()
        seen[:2], seen[2:4] = angles[0] - off, speeds[0]
        at_rest[:2], at_rest[2:4] = np.median(window.theta, axis=0) - off, 0.0
        return [seen, at_rest]

    def with_zeros(self, trials: Sequence[int]) -> Array:
        """Return the values with zeros of some trials' encoders that fit, what initial states can imitate set aside."""
        values = self._values.copy()
        for trial in trials:
            those = [k for k, window in enumerate(self._windows) if window.trial == trial]
            rows = np.concatenate([self._beside_the_start(k) for k in those])
            change = np.linalg.lstsq(rows[:, :-1], rows[:, -1])[0]
            if np.sum((rows[:, :-1] @ change) ** 2) > _TOLERANCE * np.sum(self.costs[those]):
                values[self._model.zero_places(trial)] += change
        return values

    def _beside_the_start(self, window: int) -> Array:
        """Return rows (k, zeros + 1): derivatives by these, and residuals, less what initial states imitate."""
        by_zeros = np.tri(2) @ self._model.by_zeros  # theta2 has both
        repeated = np.tile(by_zeros, (len(self.residuals[window]), 1, 1))
        of_zeros = self._windows[window].whitened(repeated).reshape(-1, by_zeros.shape[1])
        rows = np.column_stack([of_zeros, self.residuals[window].ravel()])
        basis, _ = np.linalg.qr(self._slopes[window].reshape(len(rows), -1))
        return np.asarray(rows - basis @ (basis.T @ rows))

    def _move_near(self, chosen: Indices, change: Array, expected: Array) -> None:
        """Move initial states by small steps, in which residuals are linear: no simulation is needed."""
        self.starts[chosen] += change
        self.costs[chosen] -= expected
        for window, of_window in zip(chosen, change, strict=True):
            self.residuals[window] = self.residuals[window] - self._slopes[window] @ of_window

    def _move(self, chosen: Indices, starts: Array, largest: Array, limit: float) -> Flags:
        """Move initial states (chosen, states) where that costs no more than `largest`, and return where."""
        windows, is_better = [self._windows[window] for window in chosen], np.zeros(len(chosen), dtype=bool)
        blocks = self._model.blocks(windows)

        def work(first: int, last: int) -> None:
            # A motion that cannot be computed shows in its cost.
            with np.errstate(over="ignore", invalid="ignore"):
                for block in blocks[first:last]:
                    of_block = self._move_block(chosen[block], windows[block], starts[block], largest[block], limit)
                    is_better[block] = of_block

        parallel_for(work, len(blocks))
        return is_better

    def _move_block(
        self, chosen: Indices, windows: Sequence[Window], starts: Array, largest: Array, limit: float
    ) -> list[bool]:
        model, penalty, is_better = self._model, self._model.start_penalty, list[bool]()
        theta, by_start, bounds = model.predict_together(self._values, list(starts), windows)
        samples = [slice(first, last) for first, last in pairwise(bounds.tolist())]
        for k, window, start, most, own in zip(chosen, windows, starts, largest, samples, strict=True):
            residual = window.whitened(window.theta - theta[own])
            slopes = window.whitened(by_start[own])
            size, rows = np.abs(residual), slopes.reshape(-1, model.states)
            cost = float(np.sum(np.where(size > limit, limit * (2.0 * size - limit), size**2)) + start**2 @ penalty)
            weighted = rows * (limit / np.maximum(size, limit) if limit < np.inf else np.ones_like(size)).reshape(-1, 1)
            normal = weighted.T @ rows + np.diag(penalty)
            computed = np.isfinite(cost) and np.all(np.isfinite(normal))
            is_better.append(bool((cost if computed else np.inf) <= most))
            if is_better[-1]:
                self.starts[k], self.costs[k] = start, cost if computed else np.inf
                self.residuals[k], self._slopes[k] = residual, slopes
                self._normal[k], self._right[k] = normal, weighted.T @ residual.ravel() - penalty * start
        return is_better


def _damped_step(matrices: Array, right: Array, damping: Array) -> Array:
    """Return the steps (k, n) that solve symmetric matrices (k, n, n) whose diagonals are increased by a share (k,).

    What a window hardly shows is damped like what it does; directions of which it shows nothing are left as they are.
    """
    diagonal = np.einsum("kii->ki", matrices)
    sizes = np.maximum(diagonal, _HIDDEN**2 * diagonal.max(axis=1, keepdims=True))
    scale = 1.0 / np.sqrt(np.maximum(sizes, np.finfo(float).tiny))
    scaled = matrices * scale[:, :, None] * scale[:, None, :]
    scaled += damping[:, None, None] * np.eye(matrices.shape[1])
    return scale * (np.linalg.pinv(scaled, rcond=_CUT_OFF, hermitian=True) @ (scale * right)[:, :, None])[:, :, 0]
