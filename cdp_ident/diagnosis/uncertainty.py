"""How sure the fit is of its values."""

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.initial_states import InitialState
from cdp_ident.fit.refinement import Fit

Array = npt.NDArray[np.float64]

_UNSEEN = 1e-12
"""Directions with less than this share of the largest curvature are not seen."""


def reduced_sensitivities(fit: Fit) -> list[Array]:
    """Return what of each window's sensitivities (n, 2, unknowns) its own start cannot imitate."""
    reduced, states = [], fit.model.states
    for window, sensitivity, weight in zip(fit.windows, fit.sensitivities, fit.weights, strict=True):
        rows = sensitivity.reshape(-1, sensitivity.shape[2])
        root = np.sqrt(weight.reshape(-1, 1))
        state = InitialState.of(root * rows[:, :states], window.start_known)
        by_unknowns = rows[:, states:] - rows[:, :states] @ state.change_for(root * rows[:, states:])
        reduced.append(by_unknowns.reshape(*sensitivity.shape[:2], -1))
    return reduced


def normal_equations(fit: Fit) -> tuple[Array, Array]:
    """Return what each window adds to slope and curvature of a fit's squared error, its starts following.

    The slopes (windows, unknowns) are half of it, downwards; the curvatures (windows, unknowns, unknowns) half of the
    second derivative.
    """
    slopes, bends = [], []
    for sensitivity, weight, residual in zip(reduced_sensitivities(fit), fit.weights, fit.residuals, strict=True):
        rows = sensitivity.reshape(-1, sensitivity.shape[2])
        weighted = rows * weight.reshape(-1, 1)
        slopes.append(weighted.T @ residual.ravel())
        bends.append(weighted.T @ rows)
    return np.array(slopes), np.array(bends)


def curvature(fit: Fit) -> Array:
    """Return half the second derivative (unknowns, unknowns) of a fit's squared error, its starts following."""
    return np.asarray(normal_equations(fit)[1].sum(axis=0))


def downhill(fit: Fit) -> Array:
    """Return half the slope (unknowns,) of a fit's squared error, downwards, its starts following."""
    return np.asarray(normal_equations(fit)[0].sum(axis=0))


def scaled_inverse(bend: Array, unseen: float) -> tuple[Array, Array]:
    """Return the inverse (k, k) of a curvature, and the directions (k, m) that it leaves out, of scaled unknowns.

    They are those with less than a share `unseen` of the largest curvature.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.diag(bend), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(bend * np.outer(scale, scale))
    seen = values > unseen * np.max(values, initial=0.0)
    inverse = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T * np.outer(scale, scale)
    return np.asarray(inverse), np.asarray(vectors[:, ~seen])


def effective_unknowns(fit: Fit) -> float:
    """Return how many unknowns a fit adjusts: fewer than there are where a penalty keeps some of them together."""
    penalty = fit.model.penalty
    if not np.any(penalty):
        return float(len(fit.values))
    bent = curvature(fit)
    return len(fit.values) - float(np.trace(np.linalg.pinv(bent + penalty, rcond=1e-14, hermitian=True) @ penalty))


def covariance(fit: Fit) -> Array:
    """Return the covariance (unknowns, unknowns) of the fitted values.

    It is the curvature's, corrected for residuals that are correlated in time and of different size in the two
    angles: S^-1 B S^-1 with S the curvature and B the sum of the scores' autocovariances, up to the
    correlation length of the residuals, with Bartlett's weights (Newey and West, Econometrica 55, 1987). What the
    values would change by if a trial's unit of time were another is added, as uncertain as that is. An unknown that
    the windows do not show at all gets an infinite variance. What a penalty keeps smooth has one as of a prior
    (Nychka, J. Am. Stat. Assoc. 83, 1988).
    """
    scores, bent, reduced = [], fit.model.penalty, reduced_sensitivities(fit)
    for sensitivity, residual, weight in zip(reduced, fit.residuals, fit.weights, strict=True):
        weighted = sensitivity * weight[..., None]
        bent = bent + np.tensordot(weighted, sensitivity, axes=((0, 1), (0, 1)))
        scores.append(np.einsum("nrp,nr->np", weighted, residual))
    lags = fit.autocorrelation.length
    middle = np.zeros_like(bent)
    for score in scores:
        middle += score.T @ score
        for lag in range(1, min(lags, len(score) - 1) + 1):
            product = score[lag:].T @ score[:-lag]
            middle += (1.0 - lag / (lags + 1.0)) * (product + product.T)
    if np.any(fit.model.penalty):
        of_weights = fit.model.of_weights
        of_curves = np.where(np.outer(of_weights, of_weights), 0.0, fit.model.penalty)
        middle += of_curves * (fit.variance * fit.autocorrelation.integrated_time)
        # Errors of weights are of unit variance, whatever the angles' noise is.
        middle += np.diag(np.diag(fit.model.penalty) ** 2 * of_weights)
    samples = sum(residual.size for residual in fit.residuals)
    estimated = effective_unknowns(fit) + fit.model.states * sum(not window.start_known for window in fit.windows)
    inverse, left_out = scaled_inverse(bent, _UNSEEN)
    result = inverse @ middle @ inverse * (samples / max(samples - estimated, 1))
    for change in _changes_by_units_of_time(fit, reduced):
        result += np.outer(inverse @ change, inverse @ change)
    unseen = np.any(np.abs(left_out) > 1e-3, axis=1)
    result[unseen, unseen] = np.inf
    return np.asarray(result)


def _changes_by_units_of_time(fit: Fit, reduced: list[Array]) -> list[Array]:
    """Return what a unit of time that is off by one standard deviation changes in the scores (unknowns,), by trial.

    Measured against a clock that is fast by e, a motion is where it would be e t later.
    """
    changes: dict[int, Array] = {}
    for window, sensitivity, error, weight in zip(fit.windows, reduced, fit.errors, fit.weights, strict=True):
        if window.time_std > 0.0:
            later = window.whitened(np.gradient(window.theta - error, window.time, axis=0)) * window.time[:, None]
            change = window.time_std * np.einsum("nrp,nr->p", sensitivity * weight[..., None], later)
            changes[window.trial] = changes.get(window.trial, 0.0) + change
    return list(changes.values())
