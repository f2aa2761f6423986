"""The smoothness of a torque without a name, estimated from the data.

A curve's coefficients have a normal prior, whose precisions (of second differences, and of the size of each part)
maximise the marginal likelihood of what is fitted (restricted maximum likelihood): by the fixed-point iteration of
Fellner and Schall in the general form of Wood and Fasiolo, Biometrics 73, 2017.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.stiffness import Stiffness, penalties, penalty
from cdp_ident.model.effects.effect import Curve

Array = npt.NDArray[np.float64]

_MOST_ITERATIONS = 100
_SETTLED = 0.05
"""Change of the logarithms of all precisions that ends the iteration."""
_FIRST = 1e-3
"""Initial precisions, over the data's own."""
_RANGE = 1e10
"""Precisions are within this factor of the data's own."""


@dataclass(frozen=True)
class Smooth:
    """A curve with its estimated smoothness."""

    stiffness: Stiffness
    coefficients: Array
    """(count,) over A22."""
    gain: float
    """By how much it lowers the squared error [rad^2]."""
    freedom: float
    """Its effective number of free parameters."""


def smooth_curve(curve: Curve, matrix: Array, right: Array, variance: float) -> Smooth:
    """Return the curve with maximal marginal likelihood.

    Args:
        curve: what the curve is a function of.
        matrix: (count, count) half the second derivative of the squared error by the coefficients [rad^2].
        right: (count,) half its slope downwards at zero.
        variance: of one independent residual [rad^2].
    """
    forms = penalties(curve)
    data = float(np.trace(matrix)) / curve.count
    weights: Array = np.full(len(forms), _FIRST * data)
    for _ in range(_MOST_ITERATIONS):
        prior = penalty(curve, tuple(weights))
        posterior = np.linalg.inv(matrix + prior)
        coefficients = posterior @ right
        undecided = np.linalg.inv(prior) - posterior
        sizes = np.array([coefficients @ form @ coefficients for form in forms])
        shares = variance * np.array([np.sum(undecided * form) for form in forms]) / np.maximum(sizes, 1e-300)
        before, weights = weights, np.clip(weights * shares, data / _RANGE, data * _RANGE)
        if np.max(np.abs(np.log(weights / before))) < _SETTLED:
            break
    gain = float(2.0 * coefficients @ right - coefficients @ matrix @ coefficients)
    return Smooth(tuple(weights.tolist()), coefficients, gain, float(np.trace(posterior @ matrix)))
