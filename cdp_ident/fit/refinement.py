"""The refinement: multiple shooting, from the search's result to the minimum.

All windows share the unknowns; each has its own initial state.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import zip_longest
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.autocorrelation import Autocorrelation
from cdp_ident.fit.held_values import MOST_FOR_STARTS, HeldValues, fit_each_window
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.normal_equations import (
    DAMPING_FACTOR,
    FIRST_DAMPING,
    LARGEST_DAMPING,
    LEAST_DAMPING,
    NormalEquations,
    Point,
    any_beyond,
    outlier_limit,
)
from cdp_ident.fit.windows import Window, split

Array = npt.NDArray[np.float64]
_Part = TypeVar("_Part")

_MOST_ITERATIONS = 100
_GROWTH = (4, 2)
"""Windows are first fitted in so many parts, one after the other, and then whole."""
_ROUGHLY = 1e-3
"""Tolerance of the fits of parts."""


@dataclass(frozen=True)
class Fit:
    """The model's motion over the windows under the values that fit them best."""

    model: MotionModel
    values: Array
    """(unknowns,) fitted values, in the order of `model.names`."""
    windows: tuple[Window, ...]
    """The windows, with their fitted initial states."""
    residuals: tuple[Array, ...]
    """(n, 2) measured minus simulated angles of each window, whitened [rad]."""
    sensitivities: Sequence[Array]
    """(n, 2, states + unknowns) derivatives of the simulated angles, whitened, by the window's initial state and by the
    unknowns, where these were held, by those that were not."""
    weights: tuple[Array, ...]
    """(n, 2) weight of each residual; 1 but for outliers."""
    iterations: int
    simulations: int
    """Windows simulated, as multiples of all the windows together."""
    converged: bool

    @cached_property
    def autocorrelation(self) -> Autocorrelation:
        """How far the residuals are correlated in time."""
        return Autocorrelation.of(self.residuals)

    @cached_property
    def samples(self) -> float:
        """Angles measured in the windows, those of rods at rest counted by their weights."""
        return float(
            sum(residual.shape[1] * w.independent for residual, w in zip(self.residuals, self.windows, strict=True))
        )

    @cached_property
    def squared_error(self) -> float:
        """Sum of the squared residuals [rad^2]: what is minimised, but for outliers."""
        return float(sum(np.sum(residual**2) for residual in self.residuals))

    @property
    def variance(self) -> float:
        """Mean square of the residuals [rad^2]."""
        return self.squared_error / self.samples

    @cached_property
    def errors(self) -> tuple[Array, ...]:
        """(n, 2) measured minus simulated theta1 and theta2 of each window [rad]."""
        return tuple(w.angles_of(residual) for w, residual in zip(self.windows, self.residuals, strict=True))

    def over(self, chosen: Sequence[int]) -> "Fit":
        """Return the same over some of the windows, by their indices."""
        return replace(
            self,
            windows=tuple(self.windows[index] for index in chosen),
            residuals=tuple(self.residuals[index] for index in chosen),
            sensitivities=[self.sensitivities[index] for index in chosen],
            weights=tuple(self.weights[index] for index in chosen),
        )

    def rmse(self, angle: int | None = None) -> float:
        """Root mean square error of one angle (0: theta1, 1: theta2) or of both together [rad].

        Samples in which both joints rest count by their weights.
        """
        columns = slice(None) if angle is None else slice(angle, angle + 1)
        counts = [np.max(window.counts, axis=1) for window in self.windows]
        squared = [of @ np.mean(error[:, columns] ** 2, axis=1) for of, error in zip(counts, self.errors, strict=True)]
        return float(np.sqrt(sum(squared) / sum(map(np.sum, counts))))


def refine(
    model: MotionModel,
    values: Array,
    windows: Sequence[Window],
    stop: Callable[[float], bool] = lambda rmse: False,
    tolerance: float = 1e-6,
    hold_values: bool = False,
    held: Sequence[int] = (),
) -> Fit:
    """Fit the unknowns and the windows' initial states by least squares.

    Args:
        model: gives the motion; the limits of its unknowns are kept to.
        values: (unknowns,) initial values.
        windows: what to fit, with initial guesses of their initial states.
        stop: called with the error [rad] after each iteration; true ends the fit with what it has.
        tolerance: the fit has converged when the cost decreases by less than this share in an iteration.
        hold_values: whether the unknowns keep their values and the windows' initial states alone are fitted, with
            the zeros of trials that the model does not know where each trial has its own.
        held: which other unknowns keep their values.

    Raises:
        IdentificationError: there is no window, or the motion or a step cannot be computed from the first values.
    """
    if not windows:
        raise IdentificationError("there is nothing to fit: no window of any trial has enough samples")
    if hold_values:
        model, values, free = _zeros_of_new_trials(model, values, windows)
    else:
        values, free = np.clip(values, *model.limits), np.setdiff1d(np.arange(len(values)), held)
    if not len(free):
        return _fit_of_each(fit_each_window(model, values, windows, tolerance), model, values, windows)
    problem = NormalEquations(model, windows, free, values)
    begin = values[free]
    point = problem.evaluate(begin, [window.start for window in windows], np.inf)
    if point is None:
        raise IdentificationError("the model's motion cannot be computed from the parameters to begin with")
    damping, iterations, converged, limit, curved = FIRST_DAMPING, 0, False, np.inf, False
    while iterations < (MOST_FOR_STARTS if hold_values else _MOST_ITERATIONS) and damping < LARGEST_DAMPING:
        iterations += 1
        try:
            step = problem.step(point, damping)
        except np.linalg.LinAlgError as error:  # sensitivities so large that their products are no numbers
            if iterations == 1:
                raise IdentificationError(f"the equations of the fit cannot be solved: {error}") from error
            break
        if step.expected < tolerance * point.cost and damping <= FIRST_DAMPING:  # not small because it is damped
            candidate: Point | None = problem.moved(point, step)
        else:
            path = problem.accelerated(point, step, damping) if curved else step
            candidate = problem.evaluate(path.values, path.starts, limit) if path else None
        if candidate is None or candidate.cost > point.cost:
            # At the minimum, rounding keeps the cost from decreasing: the fit has converged, too.
            if step.expected < tolerance * point.cost:
                converged = True
                break
            damping *= DAMPING_FACTOR
            curved = True
            continue
        gained = point.cost - candidate.cost
        point, damping = candidate, max(damping / DAMPING_FACTOR, LEAST_DAMPING)
        if stop(problem.rmse(point)):
            break
        if gained < tolerance * point.cost:
            # Converged under the present limit for outliers: are there residuals beyond a lower one?
            lower = outlier_limit(point.residuals)
            if limit < np.inf or not any(any_beyond(residual, lower) for residual in point.residuals):
                converged = True
                break
            limit = lower
            reweighted = problem.evaluate(point.values, point.starts, limit)
            if reweighted is None:  # the same motion as before, so it can be computed
                break
            point = reweighted
    return Fit(
        model=model,
        values=problem.all_values(point.values),
        windows=tuple(replace(w, start=s) for w, s in zip(windows, point.starts, strict=True)),
        residuals=tuple(point.residuals),
        sensitivities=point.sensitivities,
        weights=tuple(point.weights),
        iterations=iterations,
        simulations=problem.simulations,
        converged=converged,
    )


def _fit_of_each(held: HeldValues, model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit:
    return Fit(
        model=model,
        values=values,
        windows=tuple(replace(w, start=s) for w, s in zip(windows, held.starts, strict=True)),
        residuals=tuple(held.residuals),
        sensitivities=held.sensitivities,
        weights=tuple(held.weights),
        iterations=held.iterations,
        simulations=-(-held.simulated // len(windows)),
        converged=bool(np.all(held.converged)),
    )


def _zeros_of_new_trials(
    model: MotionModel, values: Array, windows: Sequence[Window]
) -> tuple[MotionModel, Array, npt.NDArray[np.int64]]:
    """Where each trial's encoders have zeros of their own, add those of trials that the model has not been fitted to.

    Returns the model, its values, and the indices of these zeros.
    """
    if not model.zeros:
        return model, values, np.empty(0, dtype=np.int64)
    new = sorted({window.trial for window in windows} - set(model.zeros))
    model, values = model.with_zeros(values, new)
    places = [np.arange(place.start, place.stop) for place in map(model.zero_places, new)]
    return model, values, np.concatenate([np.empty(0, dtype=np.int64), *places])


def refine_from_afar(
    model: MotionModel, values: Array, windows: Sequence[Window], hold_values: bool = False, tolerance: float = 1e-6
) -> Fit:
    """Refine from poor initial values and initial states, over windows of growing length.

    Over a short window even chaotic motion is almost linear in everything that is fitted, so that a poor initial guess
    does no harm. The result of the short windows is the initial guess for the longer ones.

    Raises:
        IdentificationError: as `refine`.
    """
    iterations, simulations = 0, 0
    found: list[list[Array]] = []
    for parts in _GROWTH:
        pieces = [_with_initial_states(split(window, parts), starts) for window, starts in zip_longest(windows, found)]
        fit = refine(
            model,
            values,
            [piece for of_window in pieces for piece in of_window],
            tolerance=_ROUGHLY,
            hold_values=hold_values,
        )
        model, values = fit.model, fit.values
        iterations, simulations = iterations + fit.iterations, simulations + fit.simulations
        starts = iter(window.start for window in fit.windows)
        found = [[next(starts) for _ in of_window] for of_window in pieces]
    windows = [replace(window, start=starts[0]) for window, starts in zip(windows, found, strict=True)]
    fit = refine(model, values, windows, tolerance=tolerance, hold_values=hold_values)
    return replace(fit, iterations=iterations + fit.iterations, simulations=simulations + fit.simulations)


def fit_initial_states(model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit:
    """Fit the windows' initial states alone, from poor initial guesses; all values are held."""
    return refine_from_afar(model, values, windows, hold_values=True)


def fit_initial_states_near(model: MotionModel, values: Array, windows: Sequence[Window], good_enough: float) -> Fit:
    """Fit the windows' initial states alone, from good initial guesses: those that the windows have.

    Windows in which that leaves an error above `good_enough` [rad], or all where it does not converge, are also fitted
    over windows of growing length, and each takes the better of its two initial states: with all values held, windows
    have nothing to do with each other. A joint that sticks from a wrong place on leaves one window far off, which the
    others hide. Where zeros of trials are fitted with them, all windows take the same fit.

    Raises:
        IdentificationError: as `refine`.
    """
    try:
        near = refine(model, values, windows, hold_values=True)
    except IdentificationError:
        return fit_initial_states(model, values, windows)
    apart = len(near.values) == len(values)
    every = range(len(windows))
    far = [index for index in every if not near.converged or near.over([index]).rmse() >= good_enough]
    if not far:
        return near
    chosen = far if apart else every
    try:
        afar = fit_initial_states(model, values, [windows[index] for index in chosen])
    except IdentificationError:
        return near
    if not apart:
        return min(near, afar, key=lambda fit: fit.squared_error)
    return _with_better_windows(near, far, afar)


def _with_better_windows(fit: Fit, places: Sequence[int], other: Fit) -> Fit:
    """Return a fit with those windows of another one, under the same values, that it follows with a smaller error.

    Args:
        fit: of initial states alone.
        places: which of its windows those of the other fit are.
        other: of the initial states of these.
    """
    taken = {
        place: index
        for index, place in enumerate(places)
        if np.sum(other.residuals[index] ** 2) < np.sum(fit.residuals[place] ** 2)
    }

    def of_each(own: Sequence[_Part], others: Sequence[_Part]) -> tuple[_Part, ...]:
        return tuple(others[taken[place]] if place in taken else own[place] for place in range(len(own)))

    return replace(
        fit,
        windows=of_each(fit.windows, other.windows),
        residuals=of_each(fit.residuals, other.residuals),
        sensitivities=of_each(fit.sensitivities, other.sensitivities),
        weights=of_each(fit.weights, other.weights),
        converged=fit.converged or other.converged,
    )


def with_all_derivatives(fit: Fit) -> Fit:
    """Return a fit whose values were held, with the derivatives by them too.

    Raises:
        IdentificationError: they cannot be computed.
    """
    problem = NormalEquations(fit.model, fit.windows, np.arange(len(fit.values)), fit.values)
    point = problem.evaluate(fit.values, [window.start for window in fit.windows], np.inf)
    if point is None:
        raise IdentificationError("the model's motion cannot be computed")
    return replace(
        fit, residuals=tuple(point.residuals), sensitivities=point.sensitivities, weights=tuple(point.weights)
    )


def _with_initial_states(pieces: list[Window], starts: list[Array] | None) -> list[Window]:
    """Return pieces of a window with the initial states found for pieces half as long, where there are any."""
    if starts is None or len(starts) != 2 * len(pieces):
        return pieces
    return [replace(piece, start=start) for piece, start in zip(pieces, starts[::2], strict=True)]
