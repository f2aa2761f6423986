"""The refinement: multiple shooting, which takes what the search has found to the bottom of its valley.

All windows share the unknowns; each has a start of its own. The starts are eliminated from the normal equations
window by window (they meet only through the unknowns), so that the work grows with the number of windows, not with
its cube. Source: Bock, Recent advances in parameter identification techniques for ODE, 1983; the damping is
Marquardt's (1963). Chaotic motion makes valleys that are narrow and bent: steps that follow the bend (geodesic
acceleration: Transtrum and Sethna, arXiv 1201.5885, 2012) get along them, where straight ones creep.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import STATE, Frozen, MotionModel
from cdp_ident.fit.windows import Window, split
from cdp_ident.model.parallel import share_out

Array = npt.NDArray[np.float64]

_MOST_ITERATIONS = 100
_MOST_FOR_STARTS = 25
"""Starts alone are found in few iterations, or the values that are held do not fit."""
_GROWTH = (4, 2)
"""Into how many parts windows are split before they are fitted whole."""
_ROUGHLY = 1e-3
"""Tolerance of the fits that only lead to the next longer windows."""
_LARGEST_DAMPING = 1e8
_DAMPING_FACTOR = 4.0
_PROBE = 0.1
"""How far along a step the residuals are probed for their second derivative, as a share of the step."""
_MOST_ACCELERATION = 0.75
"""A step whose acceleration is larger, over its velocity, is too long; the value is that of the method's authors."""
_WILD = 6.0
"""Residuals beyond so many robust standard deviations lose weight (Huber, Robust Statistics, 1981)."""


@dataclass(frozen=True)
class Fit:
    """The model's motion over the windows under the values that fit them best."""

    model: MotionModel | Frozen
    values: Array
    """(unknowns,) fitted values, in the order of `model.names`."""
    windows: tuple[Window, ...]
    """The windows, with their fitted starts."""
    residuals: tuple[Array, ...]
    """(n, 2) measured minus simulated angle of each window [rad]."""
    sensitivities: tuple[Array, ...]
    """(n, 2, 4 + unknowns) derivatives of the simulated angles, by the window's start and by the unknowns."""
    weights: tuple[Array, ...]
    """(n, 2) weight of each residual; 1 but for wild samples."""
    iterations: int
    simulations: int
    """Windows simulated, as multiples of all the windows together."""
    converged: bool

    @property
    def samples(self) -> int:
        """Angles measured in the windows."""
        return sum(residual.size for residual in self.residuals)

    @property
    def squared_error(self) -> float:
        """Sum of the squared residuals [rad^2]."""
        return float(sum(np.sum(residual**2) for residual in self.residuals))

    def rmse(self, joint: int | None = None) -> float:
        """Root mean square residual of one angle (0: theta1, 1: theta2) or of both together [rad]."""
        columns = slice(None) if joint is None else slice(joint, joint + 1)
        residuals = np.concatenate([residual[:, columns].ravel() for residual in self.residuals])
        return float(np.sqrt(np.mean(residuals**2)))


def refine(
    model: MotionModel | Frozen,
    values: Array,
    windows: Sequence[Window],
    stop: Callable[[float], bool] = lambda rmse: False,
    tolerance: float = 1e-6,
) -> Fit:
    """Adjust the unknowns and the windows' starts until the squared error no longer falls.

    Args:
        model: gives the motion; the limits of its unknowns are kept to.
        values: (unknowns,) values to begin with.
        windows: what to fit; their starts are what to begin with there.
        stop: called with the error [rad] after each iteration; true ends the fit with what it has.
        tolerance: relative decrease of the cost in an iteration below which the fit has arrived.

    Raises:
        IdentificationError: there is no window, or the motion cannot be computed under the first values.
    """
    if not windows:
        raise IdentificationError("there is nothing to fit: no window of any trial has enough samples")
    problem = _Problem(model, windows)
    point = problem.evaluate(np.clip(values, *model.limits), [window.start for window in windows], np.inf)
    if point is None:
        raise IdentificationError("the model's motion cannot be computed from the parameters to begin with")
    damping, iterations, converged, limit, curved = 1e-3, 0, False, np.inf, False
    while iterations < (_MOST_ITERATIONS if len(values) else _MOST_FOR_STARTS) and damping < _LARGEST_DAMPING:
        iterations += 1
        step = problem.step(point, damping)
        path = problem.accelerated(point, step, damping) if curved else step
        candidate = problem.evaluate(path.values, path.starts, limit) if path else None
        if candidate is None or candidate.cost > point.cost:
            # Rounding leaves the cost where it is once the bottom is reached: that, too, is arrival.
            if step.expected < tolerance * point.cost:
                converged = True
                break
            damping *= _DAMPING_FACTOR
            curved = True
            continue
        gained = point.cost - candidate.cost
        point, damping = candidate, max(damping / _DAMPING_FACTOR, 1e-12)
        if stop(problem.rmse(point)):
            break
        if gained < tolerance * point.cost:
            # Arrived, under the limit for wild samples so far: does the error now at hand ask for a lower one?
            lower = _WILD * problem.robust_scale(point)
            if limit < np.inf or not problem.any_beyond(point, lower):
                converged = True
                break
            limit = lower
            reweighted = problem.evaluate(point.values, point.starts, limit)
            if reweighted is None:  # the same motion as before, so it can be computed
                break
            point = reweighted
    return problem.fit(point, iterations, converged)


def refine_from_afar(model: MotionModel | Frozen, values: Array, windows: Sequence[Window]) -> Fit:
    """Refine from values and starts that may be far off, by windows that grow.

    Over a short window the motion is almost linear in everything that is adjusted, so that even a chaotic one is
    followed from a poor start; what the short windows find is where the longer ones begin.

    Raises:
        IdentificationError: as `refine`.
    """
    iterations, simulations = 0, 0
    found: list[list[Array]] = []
    for parts in _GROWTH:
        pieces = [_begun_at(split(window, parts), starts) for window, starts in zip_longest(windows, found)]
        fit = refine(model, values, [piece for of_window in pieces for piece in of_window], tolerance=_ROUGHLY)
        values, iterations, simulations = fit.values, iterations + fit.iterations, simulations + fit.simulations
        starts = iter(window.start for window in fit.windows)
        found = [[next(starts) for _ in of_window] for of_window in pieces]
    windows = [replace(window, start=starts[0]) for window, starts in zip(windows, found, strict=True)]
    fit = refine(model, values, windows)
    return replace(fit, iterations=iterations + fit.iterations, simulations=simulations + fit.simulations)


def _begun_at(pieces: list[Window], starts: list[Array] | None) -> list[Window]:
    """Return pieces of a window with the starts found for pieces half as long, where there are such."""
    if starts is None or len(starts) != 2 * len(pieces):
        return pieces
    return [replace(piece, start=start) for piece, start in zip(pieces, starts[::2], strict=True)]


@dataclass(frozen=True)
class _Point:
    """The cost at one set of values and starts, and the normal equations there."""

    values: Array
    starts: list[Array]
    cost: float
    residuals: list[Array]
    sensitivities: list[Array]
    weights: list[Array]
    normal: Array
    """(windows, 4 + unknowns, 4 + unknowns) each window's J^T W J."""
    right: Array
    """(windows, 4 + unknowns) each window's J^T W r."""


@dataclass(frozen=True)
class _Step:
    values: Array
    starts: list[Array]
    expected: float
    """By how much the linearised problem says that the cost will fall."""


class _Problem:
    """The windows, and what the damped Gauss-Newton iteration computes over them."""

    def __init__(self, model: MotionModel | Frozen, windows: Sequence[Window]):
        self._model = model
        self._windows = tuple(windows)
        self._known_start = np.array([window.start_known for window in windows])
        self._simulations = 0

    def evaluate(self, values: Array, starts: list[Array], limit: float) -> _Point | None:
        """Return cost and normal equations, or None where the motion cannot be computed.

        Residuals beyond `limit` [rad] enter the cost with their absolute value only (Huber).
        """
        self._simulations += 1
        size = STATE + len(values)
        residuals: list[Array] = [np.empty(0)] * len(self._windows)
        sensitivities, weights = list(residuals), list(residuals)
        normal = np.empty((len(self._windows), size, size))
        right = np.empty((len(self._windows), size))
        costs = np.empty(len(self._windows))

        def work(first: int, last: int) -> None:
            for index in range(first, last):
                window = self._windows[index]
                theta, sensitivity = self._model.predict(values, starts[index], window)
                residual = window.theta - theta
                size_of = np.abs(residual)
                weight = np.where(size_of > limit, limit / np.maximum(size_of, limit), 1.0) if limit < np.inf else None
                rows, flat = sensitivity.reshape(-1, size), residual.ravel()
                weighted = rows if weight is None else rows * weight.reshape(-1, 1)
                normal[index], right[index] = weighted.T @ rows, weighted.T @ flat
                costs[index] = (
                    flat @ flat
                    if weight is None
                    else np.sum(np.where(size_of > limit, limit * (2 * size_of - limit), size_of**2))
                )
                residuals[index], sensitivities[index] = residual, sensitivity
                weights[index] = np.ones_like(residual) if weight is None else weight

        share_out(work, len(self._windows))
        if not np.all(np.isfinite(costs)) or not np.all(np.isfinite(normal)):
            return None
        return _Point(values, starts, float(costs.sum()), residuals, sensitivities, weights, normal, right)

    def step(self, point: _Point, damping: float) -> _Step:
        """Return the damped Gauss-Newton step."""
        change, start_changes = self._solve(point.values, point.normal, point.right, damping)
        right = np.where(self._known_start[:, None], 0.0, point.right[:, :STATE])
        expected = float(change @ point.right[:, STATE:].sum(axis=0) + np.sum(start_changes * right))
        return _Step(point.values + change, _moved(point.starts, start_changes), expected)

    def accelerated(self, point: _Point, step: _Step, damping: float) -> _Step | None:
        """Return a step with its geodesic acceleration, or None where that is too large for the step to be trusted."""
        change = step.values - point.values
        velocity = np.array([[*(b - a), *change] for a, b in zip(point.starts, step.starts, strict=True)])
        near = _PROBE * velocity
        probe = self.evaluate(point.values + _PROBE * change, _moved(point.starts, near[:, :STATE]), np.inf)
        if probe is None:
            return None
        right = np.empty_like(point.right)
        parts = zip(point.residuals, probe.residuals, point.sensitivities, point.weights, near, strict=True)
        for index, (residual, probed, sensitivity, weight, moved) in enumerate(parts):
            half_second_derivative = (probed - residual + sensitivity @ moved) / _PROBE**2
            right[index] = np.einsum("nj,njk->k", weight * half_second_derivative, sensitivity)
        more, more_starts = self._solve(step.values, point.normal, right, damping)
        half_acceleration = np.array([[*moved, *more] for moved in more_starts])
        scale = np.einsum("wkk->wk", point.normal)
        if 4.0 * np.sum(scale * half_acceleration**2) > _MOST_ACCELERATION**2 * np.sum(scale * velocity**2):
            return None
        return replace(step, values=step.values + more, starts=_moved(step.starts, more_starts))

    def _solve(self, values: Array, normal: Array, right: Array, damping: float) -> tuple[Array, Array]:
        """Solve the damped normal equations, the starts eliminated window by window.

        Args:
            values: (unknowns,) what the change must leave within its limits.
            normal: (windows, 4 + unknowns, 4 + unknowns) matrix of each window.
            right: (windows, 4 + unknowns) right-hand side of each window.
            damping: by which share the diagonals grow.

        Returns:
            Change of the unknowns (unknowns,), and of the windows' starts (windows, 4).
        """
        normal, right = normal.copy(), right.copy()
        diagonal = np.arange(normal.shape[1])
        normal[:, diagonal, diagonal] *= 1.0 + damping
        normal[self._known_start, :STATE] = 0.0
        normal[self._known_start, :, :STATE] = 0.0
        normal[np.ix_(self._known_start, diagonal[:STATE], diagonal[:STATE])] = np.eye(STATE)
        right[self._known_start, :STATE] = 0.0

        by_start, mixed = normal[:, :STATE, :STATE], normal[:, :STATE, STATE:]
        eliminated = np.linalg.solve(by_start, np.concatenate([mixed, right[:, :STATE, None]], axis=2))
        mixed_transposed = mixed.transpose(0, 2, 1)
        reduced = (normal[:, STATE:, STATE:] - mixed_transposed @ eliminated[:, :, :-1]).sum(axis=0)
        reduced_right = (right[:, STATE:] - (mixed_transposed @ eliminated[:, :, -1:])[:, :, 0]).sum(axis=0)
        change = self._solve_within_limits(values, reduced, reduced_right)
        return change, eliminated[:, :, -1] - eliminated[:, :, :-1] @ change

    def _solve_within_limits(self, values: Array, matrix: Array, right: Array) -> Array:
        """Solve for the unknowns' change; one that would leave its range goes to its limit and no further."""
        lower, upper = self._model.limits
        change = np.zeros(len(values))
        free = np.ones(len(values), dtype=bool)
        scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
        while np.any(free):
            rows = np.ix_(free, free)
            scaled = matrix[rows] * np.outer(scale[free], scale[free])
            rest = (right - matrix[:, ~free] @ change[~free])[free] * scale[free]
            change[free] = np.linalg.lstsq(scaled, rest, rcond=1e-14)[0] * scale[free]
            outside = free & ((values + change < lower) | (values + change > upper))
            if not np.any(outside):
                break
            change[outside] = np.clip(values + change, lower, upper)[outside] - values[outside]
            free &= ~outside
        return change

    def rmse(self, point: _Point) -> float:
        return float(np.sqrt(sum(np.sum(r**2) for r in point.residuals) / sum(r.size for r in point.residuals)))

    def robust_scale(self, point: _Point) -> float:
        """Return the standard deviation of the residuals as their median size has it [rad]."""
        return 1.4826 * float(np.median(np.abs(np.concatenate([r.ravel() for r in point.residuals]))))

    def any_beyond(self, point: _Point, limit: float) -> bool:
        return any(bool(np.any(np.abs(residual) > limit)) for residual in point.residuals)

    def fit(self, point: _Point, iterations: int, converged: bool) -> Fit:
        return Fit(
            model=self._model,
            values=point.values,
            windows=tuple(replace(w, start=s) for w, s in zip(self._windows, point.starts, strict=True)),
            residuals=tuple(point.residuals),
            sensitivities=tuple(point.sensitivities),
            weights=tuple(point.weights),
            iterations=iterations,
            simulations=self._simulations,
            converged=converged,
        )


def _moved(starts: Sequence[Array], changes: Array) -> list[Array]:
    return [start + change for start, change in zip(starts, changes, strict=True)]
