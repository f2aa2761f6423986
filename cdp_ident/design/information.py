"""The information that windows hold on values, beside what their initial states could imitate."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.initial_states import InitialState
from cdp_ident.fit.refinement import Fit

Array = npt.NDArray[np.float64]


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
