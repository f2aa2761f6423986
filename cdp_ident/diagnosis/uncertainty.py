"""The uncertainty of a fit's values."""

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.remembered_noise import Followed, Process, autoregressive
from cdp_ident.fit.autocorrelation import Autocorrelation, long_run_products
from cdp_ident.fit.initial_states import InitialState, inverse_factor
from cdp_ident.fit.refinement import Fit

Array = npt.NDArray[np.float64]

_UNOBSERVABLE = 1e-12
"""Directions with less than this share of the largest curvature count as unobservable."""


def eliminated(fit: Fit) -> Iterator[InitialState]:
    """Yield the part of each window's weighted rows that its initial state explains."""
    states = fit.model.states
    return InitialState.of_each(
        ((np.sqrt(weight)[..., None] * sensitivity[..., :states]).reshape(-1, states), window.start_known)
        for window, sensitivity, weight in zip(fit.windows, fit.sensitivities, fit.weights, strict=True)
    )


def reduced_sensitivities(fit: Fit) -> Iterator[Array]:
    """Yield each window's sensitivities (n, 2, unknowns), less the part that its initial state could imitate."""
    states = fit.model.states
    for state, sensitivity, weight in zip(eliminated(fit), fit.sensitivities, fit.weights, strict=True):
        rows = sensitivity.reshape(-1, sensitivity.shape[2])
        root = np.sqrt(weight.reshape(-1, 1))
        by_unknowns = rows[:, states:] - rows[:, :states] @ state.change_for(root * rows[:, states:])
        yield by_unknowns.reshape(*sensitivity.shape[:2], -1)


def normal_equations(fit: Fit) -> tuple[Array, Array]:
    """Return the gradient and curvature of a fit's squared error, by window, initial states eliminated.

    The gradients (windows, unknowns) are minus half the derivative, the curvatures (windows, unknowns, unknowns) half
    the second derivative.
    """
    windows, unknowns = len(fit.windows), len(fit.values)
    gradients, curvatures = np.empty((windows, unknowns)), np.empty((windows, unknowns, unknowns))
    parts = zip(reduced_sensitivities(fit), fit.weights, fit.residuals, strict=True)
    for index, (sensitivity, weight, residual) in enumerate(parts):
        rows = sensitivity.reshape(-1, sensitivity.shape[2])
        weighted = rows * weight.reshape(-1, 1)
        gradients[index] = weighted.T @ residual.ravel()
        curvatures[index] = weighted.T @ rows
    return gradients, curvatures


def curvature(fit: Fit) -> Array:
    """Return half the second derivative (unknowns, unknowns) of a fit's squared error, initial states eliminated."""
    return np.asarray(normal_equations(fit)[1].sum(axis=0))


def negative_gradient(fit: Fit) -> Array:
    """Return minus half the gradient (unknowns,) of a fit's squared error, initial states eliminated."""
    return np.asarray(normal_equations(fit)[0].sum(axis=0))


def scaled_inverse(matrix: Array, cut_off: float, sizes: Array | None = None) -> tuple[Array, Array]:
    """Return the inverse (k, k) of a curvature, and the directions (k, m) that it leaves out, of scaled unknowns.

    These have less than a share `cut_off` of the largest curvature. Each unknown is scaled by its own, or by `sizes`
    (k,) where another curvature is the measure.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix) if sizes is None else sizes, np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    kept = values > cut_off * np.max(values, initial=0.0)
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T * np.outer(scale, scale)
    return np.asarray(inverse), np.asarray(vectors[:, ~kept])


def covariance(fit: Fit, held: Sequence[int] = ()) -> Array:
    """Return the covariance (unknowns, unknowns) of the fitted values, zero for those that were held.

    It is the curvature's, corrected for residuals that are correlated in time and of different size in the two angles:
    S^-1 B S^-1 with S the curvature and B the covariance of the scores. Noise is taken for an autoregressive process
    (`remembered_noise`). What is new in each of its samples is in the scores with the weight of all that it is carried
    on to; B is the sum of these products, and of their autocovariances as far as what is new is correlated after all,
    with Bartlett's weights (Andrews and Monahan, Econometrica 60, 1992). The uncertainty of each trial's unit of time
    is added. An unknown that the windows do not determine at all gets an infinite variance.
    """
    roots = [np.sqrt(weight) for weight in fit.weights]
    residuals = [root * residual for root, residual in zip(roots, fit.residuals, strict=True)]
    explained, reduced = [], []
    for sensitivity, root, state in zip(fit.sensitivities, roots, eliminated(fit), strict=True):
        rows = (root[..., None] * sensitivity).reshape(-1, sensitivity.shape[2])
        explained.append(state.basis.reshape(*root.shape, -1))
        reduced.append(state.eliminated_from(rows[:, fit.model.states :]).reshape(*root.shape, -1))
    squares = [np.tensordot(rows, rows, axes=((0, 1), (0, 1))) for rows in reduced]
    information = np.sum(squares, axis=0) + fit.model.penalty
    sizes = [np.sqrt(window.counts.mean(axis=1, keepdims=True)) for window in fit.windows]
    process = autoregressive(residuals, sizes, Followed(explained, reduced, inverse_factor(information)))
    middle = _covariance_of_scores(process, residuals, reduced)
    # Errors of weights are of unit variance, whatever the angles' noise is.
    middle += fit.model.penalty_of_errors * fit.model.penalty
    free = np.setdiff1d(np.arange(len(information)), held)
    inverse = np.zeros_like(information)
    inverse[np.ix_(free, free)], left_out = scaled_inverse(information[np.ix_(free, free)], _UNOBSERVABLE)
    result = inverse @ middle @ inverse
    for change in _changes_by_units_of_time(fit):
        result += np.outer(inverse @ change, inverse @ change)
    undetermined = free[np.any(np.abs(left_out) > 1e-3, axis=1)]
    result[undetermined, undetermined] = np.inf
    return np.asarray(result)


def _covariance_of_scores(process: Process, residuals: Sequence[Array], reduced: Sequence[Array]) -> Array:
    """Return the covariance (unknowns, unknowns) of the sum of noise times sensitivities over windows."""
    new = [process.new_in(residual) for residual in residuals]
    lags = Autocorrelation.of(new).length
    unknowns = reduced[0].shape[2]
    total = np.zeros((unknowns, unknowns))
    for of_window, rows in zip(new, reduced, strict=True):
        carried = process.spread_back(rows)
        known = len(carried) - len(of_window)
        scores = np.einsum("nrp,nr->np", carried[known:], of_window)
        before = carried[:known].reshape(-1, unknowns)
        total += long_run_products(scores, lags) / process.loss + process.variance * before.T @ before
    return total


def _changes_by_units_of_time(fit: Fit) -> list[Array]:
    """Return the change of the scores (unknowns,) by an error of each trial's unit of time of one standard deviation.

    Measured against a clock that is fast by e, a motion is where it would be e t later.
    """
    changes: dict[int, Array] = {}
    if not any(window.time_std > 0.0 for window in fit.windows):
        return []
    reduced = reduced_sensitivities(fit)
    for window, sensitivity, error, weight in zip(fit.windows, reduced, fit.errors, fit.weights, strict=True):
        if window.time_std > 0.0:
            later = window.whitened(np.gradient(window.theta - error, window.time, axis=0)) * window.time[:, None]
            change = window.time_std * np.einsum("nrp,nr->p", sensitivity * weight[..., None], later)
            changes[window.trial] = changes.get(window.trial, 0.0) + change
    return list(changes.values())
