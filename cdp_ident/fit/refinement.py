"""How a model follows the motion over windows, each from an initial state of its own, its values held or fitted."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

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
)
from cdp_ident.fit.windows import Window

Array = npt.NDArray[np.float64]

_MOST_ITERATIONS = 100
_TOLERANCE = 1e-6
"""A fit has converged when the cost decreases by less than this share in an iteration."""


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
) -> Fit:
    """Fit the unknowns and the windows' initial states by least squares.

    Args:
        model: gives the motion; the limits of its unknowns are kept to.
        values: (unknowns,) initial values.
        windows: what to fit, with initial guesses of their initial states.
        stop: called with the error [rad] after each iteration; true ends the fit with what it has.

    Raises:
        IdentificationError: there is no window, or the motion or a step cannot be computed from the first values.
    """
    return _minimised(model, np.clip(values, *model.limits), windows, np.arange(len(values)), _MOST_ITERATIONS, stop)


def fit_initial_states(model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit:
    """Fit the windows' initial states alone, with the zeros of trials that the model does not know, where it has such.

    Args:
        model: gives the motion.
        values: (unknowns,) that are held.
        windows: what to fit, with initial guesses of their initial states.

    Raises:
        IdentificationError: as `refine`.
    """
    model, values, free = _zeros_of_new_trials(model, values, windows)
    if len(free):
        return _minimised(model, values, windows, free, MOST_FOR_STARTS)
    _refuse_none(windows)
    return _fit_of_each(fit_each_window(model, values, windows, _TOLERANCE), model, values, windows)


def _refuse_none(windows: Sequence[Window]) -> None:
    if not windows:
        raise IdentificationError("there is nothing to fit: no window of any trial has enough samples")


def _minimised(
    model: MotionModel,
    values: Array,
    windows: Sequence[Window],
    free: npt.NDArray[np.int64],
    most_iterations: int,
    stop: Callable[[float], bool] = lambda rmse: False,
) -> Fit:
    """Fit those unknowns that are free, and the windows' initial states."""
    _refuse_none(windows)
    problem = NormalEquations(model, windows, free, values)
    point = problem.evaluate(values[free], [window.start for window in windows], np.inf)
    if point is None:
        raise IdentificationError("the model's motion cannot be computed from the parameters to begin with")
    damping, iterations, converged = FIRST_DAMPING, 0, False
    while iterations < most_iterations and damping < LARGEST_DAMPING and not converged:
        iterations += 1
        try:
            step = problem.step(point, damping)
        except np.linalg.LinAlgError as error:  # sensitivities so large that their products are no numbers
            if iterations == 1:
                raise IdentificationError(f"the equations of the fit cannot be solved: {error}") from error
            break
        is_small = step.expected < _TOLERANCE * point.cost
        if is_small and damping <= FIRST_DAMPING:  # not small because it is damped
            candidate: Point | None = problem.moved(point, step)
        else:
            candidate = problem.evaluate(step.values, step.starts, np.inf)
        if candidate is None or candidate.cost > point.cost:
            # At the minimum, rounding keeps the cost from decreasing: the fit has converged, too.
            converged = is_small
            damping *= DAMPING_FACTOR
            continue
        converged = point.cost - candidate.cost < _TOLERANCE * point.cost
        point, damping = candidate, max(damping / DAMPING_FACTOR, LEAST_DAMPING)
        if stop(problem.rmse(point)):
            break
    return Fit(
        model=model,
        values=problem.all_values(point.values),
        windows=tuple(replace(w, start=s) for w, s in zip(windows, point.starts, strict=True)),
        residuals=tuple(point.residuals),
        sensitivities=point.sensitivities,
        weights=tuple(point.weights),
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
