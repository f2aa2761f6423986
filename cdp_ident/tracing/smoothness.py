"""How smooth a torque without a name is: as the data say.

A curve's coefficients have a normal prior, whose two precisions (of their size, and of their bends) maximise the
marginal likelihood of what is fitted (restricted maximum likelihood): by the fixed-point iteration of Fellner and
Schall in the general form of Wood and Fasiolo, Biometrics 73, 2017.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.curves import penalties
from cdp_ident.model.effects.effect import Curve

Array = npt.NDArray[np.float64]

_MOST_ITERATIONS = 100
_SETTLED = 0.02
"""Change of the logarithms of both precisions that ends the iteration."""
_FIRST = 1e-3
"""Precisions to begin with, over the data's own."""
_RANGE = 1e10
"""Precisions are within this factor of the data's own."""


@dataclass(frozen=True)
class Smooth:
    """A curve as smooth as the data say."""

    stiffness: tuple[float, float]
    """What the squares of the coefficients and of the bends add to the cost [rad^2]; see `penalties`."""
    coefficients: Array
    """(count,) over A22."""
    gain: float
    """By how much it lowers the squared error [rad^2]."""
    freedom: float
    """How many free parameters it is worth."""


def smooth_curve(curve: Curve, matrix: Array, right: Array, variance: float) -> Smooth:
    """Return the curve that explains most and is as smooth as the data say.

    Args:
        curve: what it goes over.
        matrix: (count, count) half the second derivative of the squared error by the coefficients [rad^2].
        right: (count,) half its slope downwards at zero.
        variance: of one independent residual [rad^2].
    """
    forms = penalties(curve)
    data = float(np.trace(matrix)) / curve.count
    weights: Array = np.full(2, _FIRST * data)
    for _ in range(_MOST_ITERATIONS):
        prior = weights[0] * forms[0] + weights[1] * forms[1]
        posterior = np.linalg.inv(matrix + prior)
        coefficients = posterior @ right
        undecided = np.linalg.inv(prior) - posterior
        shares = [variance * np.sum(undecided * form) / (coefficients @ form @ coefficients) for form in forms]
        before, weights = weights, np.clip(weights * shares, data / _RANGE, data * _RANGE)
        if np.max(np.abs(np.log(weights / before))) < _SETTLED:
            break
    gain = float(2.0 * coefficients @ right - coefficients @ matrix @ coefficients)
    return Smooth((float(weights[0]), float(weights[1])), coefficients, gain, float(np.trace(posterior @ matrix)))
