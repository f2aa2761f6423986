"""The normal equations of all windows together, from which the windows' initial states are eliminated.

The initial states are coupled only through the common unknowns. So they are eliminated window by window, and the work
grows with the number of windows, not with its cube. Source: Bock, Recent advances in parameter identification
techniques for ODE, 1983; the damping is Marquardt's (1963).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.bounded import minimum_within_limits
from cdp_ident.fit.initial_states import inverse_factor
from cdp_ident.fit.kept_columns import Normals, Sensitivities
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.weighted_rows import WeightedRows
from cdp_ident.fit.windows import Window
from cdp_ident.machine.parallel import parallel_for

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

FIRST_DAMPING, LEAST_DAMPING, LARGEST_DAMPING = 1e-3, 1e-12, 1e8
DAMPING_FACTOR = 4.0
"""By which the damping changes after each step: down after a good one, up after a bad one."""
OUTLIER = 6.0
"""Residuals beyond so many robust standard deviations lose weight (Huber, Robust Statistics, 1981)."""
_HIDDEN = 1e-3
"""A part of an initial state is damped as if it moved the angles by at least this share of what another one does: a
joint that stops at once hides the speed that it begins with."""


@dataclass(frozen=True)
class Point:
    """The cost at one set of values and initial states, and the normal equations there."""

    values: Array
    starts: list[Array]
    cost: float
    residuals: list[Array]
    sensitivities: Sensitivities
    weights: list[Array]
    normal: Normals
    """(states + unknowns, states + unknowns) each window's J^T W J."""
    right: Array
    """(windows, states + unknowns) each window's J^T W r."""


@dataclass(frozen=True)
class Step:
    """A step: the values and initial states that it leads to."""

    values: Array
    starts: list[Array]
    expected: float
    """Fall of the cost that the linearised problem predicts."""


@dataclass(frozen=True)
class _Block:
    """Windows that are simulated together, and their samples end to end."""

    windows: slice
    """Which they are."""
    theta: Array
    """(samples, 2) measured angles [rad]."""
    whitening: Array
    """(samples, 2, 2) matrix of each sample; see `Window.whitened`."""

    @classmethod
    def of(cls, windows: Sequence[Window], chosen: slice) -> "_Block":
        of_block = windows[chosen]
        return cls(
            chosen,
            np.concatenate([window.theta for window in of_block]),
            np.concatenate([window.whitening for window in of_block]),
        )


class NormalEquations:
    """The damped Gauss-Newton problem of all windows."""

    def __init__(self, model: MotionModel, windows: Sequence[Window], free: Indices, held: Array):
        """Begin.

        Args:
            model: gives the motion.
            windows: what is fitted.
            free: indices of the unknowns that are fitted along with the initial states.
            held: (unknowns,) values of the unknowns that are not fitted.
        """
        self._model, self._free, self._held = model, free, held
        self._columns = np.concatenate([np.arange(model.states), model.states + free])
        self._derivatives: Literal["all", "start"] = "start" if np.all(model.of_zeros[free]) else "all"
        self._penalty, self._known = model.penalty[np.ix_(free, free)], model.known[0][free]
        self._windows = tuple(windows)
        self._blocks = [_Block.of(self._windows, block) for block in model.blocks(self._windows)]
        self._known_start = np.array([window.start_known for window in windows])
        self.simulations = 0
        """Number of simulations of all windows."""

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lowest and highest value of each unknown that is fitted."""
        lower, upper = self._model.limits
        return lower[self._free], upper[self._free]

    def all_values(self, values: Array) -> Array:
        """Return the values of all unknowns (unknowns,), given those that are fitted."""
        whole = self._held.copy()
        whole[self._free] = values
        return whole

    def evaluate(self, values: Array, starts: list[Array], limit: float) -> Point | None:
        """Return cost and normal equations, or None where the motion cannot be computed.

        Residuals beyond `limit` [rad] enter the cost with their absolute value only (Huber).
        """
        point, costs = self.evaluate_each(values, starts, limit)
        return point if np.all(np.isfinite(costs)) else None

    def evaluate_each(self, values: Array, starts: Sequence[Array], limit: float) -> tuple[Point, Array]:
        """Return the same, and each window's part of the cost (windows,): infinite where there is no motion."""
        self.simulations += 1
        size = self._model.states + len(values)
        starts = [self._model.initial_state(start) for start in starts]
        all_values = self.all_values(values)
        windows = len(self._windows)
        residuals: list[Array] = [np.empty(0)] * windows
        weights = list(residuals)
        sensitivities, normal = Sensitivities(windows, size), Normals(windows, size)
        right, costs = np.empty((windows, size)), np.empty(windows)
        penalty, of_start = self._model.start_penalty, np.arange(self._model.states)

        def evaluate_block(index: int) -> None:
            block = self._blocks[index]
            theta, derivatives, bounds = self._model.predict_together(
                all_values, starts[block.windows], self._windows[block.windows], self._derivatives
            )
            theta = np.ascontiguousarray(theta)  # compiled code is for such arrays alone
            rows = WeightedRows.of(block.theta, theta, derivatives, self._columns, block.whitening, bounds, limit)
            finite = np.all(np.isfinite(rows.normal), axis=(1, 2)) & np.isfinite(rows.costs)
            begin = np.array(starts[block.windows])
            rows.normal[:, of_start, of_start] += penalty
            right[block.windows] = rows.right
            costs[block.windows] = np.where(finite, rows.costs + begin**2 @ penalty, np.inf)
            right[block.windows, of_start] -= penalty * begin
            samples = [slice(first, end) for first, end in pairwise(bounds.tolist())]
            for window, own, matrix in zip(range(windows)[block.windows], samples, rows.normal, strict=True):
                residuals[window], weights[window] = rows.residuals[own], rows.weights[own]
                sensitivities.put(window, rows.sensitivities[own])
                normal.put(window, matrix)

        def work(first: int, last: int) -> None:
            # A motion that cannot be computed shows in its cost.
            with np.errstate(over="ignore", invalid="ignore"):
                for index in range(first, last):
                    evaluate_block(index)

        parallel_for(work, len(self._blocks))
        off = values - self._known
        cost = float(costs.sum() + off @ self._penalty @ off)
        return Point(values, starts, cost, residuals, sensitivities, weights, normal, right), costs

    def step(self, point: Point, damping: float) -> Step:
        """Return the damped Gauss-Newton step."""
        penalised = self._penalty @ (point.values - self._known)
        change, start_changes = self._solve(point.values, point.normal, point.right, damping, penalised)
        states = self._model.states
        right = np.where(self._known_start[:, None], 0.0, point.right[:, :states])
        falls = point.right[:, states:].sum(axis=0) - penalised
        expected = float(change @ falls + np.sum(start_changes * right))
        return Step(point.values + change, _moved(point.starts, start_changes), expected)

    def moved(self, point: Point, step: Step) -> Point:
        """Return the point that a small step leads to, in which the residuals are linear: no simulation is needed."""
        moves = _moves(point, step)
        residuals = [r - s @ move for r, s, move in zip(point.residuals, point.sensitivities, moves, strict=True)]
        right = point.right - point.normal.times(moves)
        return replace(
            point,
            values=step.values,
            starts=step.starts,
            cost=point.cost - step.expected,
            residuals=residuals,
            right=right,
        )

    def _solve(
        self, values: Array, normal: Normals, right: Array, damping: float, penalised: Array
    ) -> tuple[Array, Array]:
        """Solve the damped normal equations, the initial states eliminated window by window.

        Args:
            values: (unknowns,) current values; with the change they stay within their limits.
            normal: (states + unknowns, states + unknowns) matrix of each window.
            right: (windows, states + unknowns) right-hand side of each window.
            damping: relative increase of the diagonals.
            penalised: (unknowns,) half the gradient of the penalty.

        Returns:
            Change of the unknowns (unknowns,), and of the windows' initial states (windows, states).
        """
        states = self._model.states
        matrices, sides, of_starts = [], [], []
        for part, whole in normal.parts():
            damp(whole, states, damping)
            by_state, mixed = whole[:, :states, :states], whole[:, :states, states:]
            factor = np.where(self._known_start[part, None, None], 0.0, inverse_factor(by_state))
            both = np.concatenate([mixed, right[part, :states, None]], axis=2)
            of_part = factor @ (factor.transpose(0, 2, 1) @ both)
            mixed_transposed = mixed.transpose(0, 2, 1)
            matrices.append((whole[:, states:, states:] - mixed_transposed @ of_part[:, :, :-1]).sum(axis=0))
            sides.append((right[part, states:] - (mixed_transposed @ of_part[:, :, -1:])[:, :, 0]).sum(axis=0))
            of_starts.append(of_part)
        eliminated = np.concatenate(of_starts)
        lower, upper = self.limits
        change = minimum_within_limits(
            sum(matrices) + self._penalty, sum(sides) - penalised, lower - values, upper - values
        )
        return change, eliminated[:, :, -1] - eliminated[:, :, :-1] @ change

    def rmse(self, point: Point) -> float:
        """Return the root mean square residual [rad]."""
        return float(np.sqrt(sum(np.sum(r**2) for r in point.residuals) / sum(r.size for r in point.residuals)))


def outlier_limit(residuals: Sequence[Array]) -> float:
    """Return the residual [rad] beyond which they lose weight, by a robust standard deviation: their median size."""
    median = float(np.median(np.abs(np.concatenate([r.ravel() for r in residuals]))))
    return max(OUTLIER * 1.4826 * median, np.finfo(float).tiny)


def any_beyond(residuals: Array, limit: float) -> bool:
    """Return whether a residual is beyond a limit [rad]."""
    return bool(np.any(np.abs(residuals) > limit))


def damp(matrices: Array, states: int, damping: Array | float) -> None:
    """Increase the diagonals of windows' matrices (windows, states + unknowns, states + unknowns), in place.

    Args:
        matrices: J^T W J of each window.
        states: how many of their columns are those of the initial state.
        damping: relative increase, of all or of each (windows, 1).
    """
    diagonal = np.arange(matrices.shape[1])
    scales = matrices[:, diagonal, diagonal]
    of_states = scales[:, :states]
    scales[:, :states] = np.maximum(of_states, _HIDDEN**2 * of_states.max(axis=1, keepdims=True))
    matrices[:, diagonal, diagonal] += damping * scales


def _moves(point: Point, step: Step) -> Array:
    """Return by how much a step changes each window's initial state and the unknowns (windows, states + unknowns)."""
    change = step.values - point.values
    return np.array([[*(b - a), *change] for a, b in zip(point.starts, step.starts, strict=True)])


def _moved(starts: Sequence[Array], changes: Array) -> list[Array]:
    return [start + change for start, change in zip(starts, changes, strict=True)]
