"""Errors of theta1 and theta2 made independent and alike: feasible generalised least squares.

Where the outer encoder turns with the inner rod, theta2 is the sum of two readings, and its noise is correlated with
theta1's; a camera measures both angles separately. Once a fit leaves nothing but noise, its errors show their
covariance, and the next fit weights both angles by it (Zellner, J. Am. Stat. Assoc. 57, 1962). As long as the model
lacks an effect, its errors are not noise, and both angles have the same weight. Single samples that are far off among
such errors are spikes of an encoder, and lose their weight.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.refinement import Fit, refine
from cdp_ident.fit.spikes import spikes

Array = npt.NDArray[np.float64]

_MOST_UNEQUAL = 10.0
"""Largest ratio of the weights of two combinations of the angles."""
_NOISE = 1.5
"""Errors above so many times the noise contain more than noise."""
_AS_BEFORE = 0.1
"""Weights are not changed by less than this share."""
_MOSTLY = 0.5
"""Least share of independent samples in a window that shows an encoder's noise."""
_ROUNDS = 4
"""Without the spikes that were found, weights are better, and may show more of them."""
_OF_SPIKE = 1e-6
"""Weight of a spike: none that changes a number, but its error can still be told."""


def reweighted(fit: Fit, noise: float) -> Fit:
    """Return a fit whose errors of both angles are weighted by their covariance, spikes left out, if they are noise.

    Args:
        fit: all its windows have the same weights.
        noise: root mean square of that of both angles [rad].

    Raises:
        IdentificationError: the motion cannot be computed.
    """
    if fit.rmse() > _NOISE * noise:
        return fit
    for _ in range(_ROUNDS):
        again = _reweighted_once(fit)
        if again is fit:
            break
        fit = again
    return fit


def _reweighted_once(fit: Fit) -> Fit:
    before = [window.counts for window in fit.windows]
    weights = before
    for _ in range(_ROUNDS):
        white = whitening(usual_covariance(fit, weights))
        found = spikes([error @ white.T for error in fit.errors])
        last, weights = weights, [np.where(off[:, None], _OF_SPIKE, of) for off, of in zip(found, before, strict=True)]
        if all(map(np.array_equal, weights, last)):
            break
    changed = [not np.array_equal(*both) for both in zip(weights, before, strict=True)]
    if not any(changed) and all(np.allclose(window.whitening, white, atol=_AS_BEFORE) for window in fit.windows):
        return fit
    windows = [
        replace(window, whitening=white, sample_weights=of if other else window.sample_weights)
        for window, of, other in zip(fit.windows, weights, changed, strict=True)
    ]
    return refine(fit.model, fit.values, windows)


def usual_covariance(fit: Fit, weights: Sequence[Array]) -> Array:
    """Return the covariance (2, 2) of the errors in the half of the windows where they are smallest [rad^2].

    So an event in a single window does not affect it. Where rods are at rest, their encoders show no noise: windows in
    which they mostly are, are left out, unless all are such.

    Args:
        fit: leaves the errors.
        weights: (n, 2) of each window's readings; samples count as their least.
    """
    weights = [np.min(of, axis=1) for of in weights]
    counts = [float(np.sum(of)) for of in weights]
    shares = [count / len(of) for count, of in zip(counts, weights, strict=True)]
    least = min(_MOSTLY, max(shares))
    products, lengths = [], []
    for error, of, count, share in zip(fit.errors, weights, counts, shares, strict=True):
        if share >= least:
            products.append(error.T @ (error * of[:, None]) / count)
            lengths.append(count)
    sizes = np.trace(products, axis1=1, axis2=2)
    usual = sizes <= np.median(sizes)
    return np.asarray(np.average(np.array(products)[usual], axis=0, weights=np.array(lengths)[usual]))


def whitening(covariance: Array) -> Array:
    """Return the matrix (2, 2) that makes errors of a covariance white, and as large as before in the mean."""
    mean = float(np.trace(covariance)) / 2.0
    if mean == 0.0:
        return np.eye(2)
    variances, directions = np.linalg.eigh(covariance / mean)
    variances = np.maximum(variances, variances[-1] / _MOST_UNEQUAL**2)
    bounded = directions * variances @ directions.T
    return np.asarray(np.linalg.inv(np.linalg.cholesky(bounded * 2.0 / np.trace(bounded))))
