"""Constants of the mechanism that formulas of effects use, and their places in the array `constants`."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

GRAVITY, LENGTH, OUTER_LENGTH, CARRIED = 6, 7, 8, 9
"""Places of g, the last of the seven coefficients, and after these: L and the outer rod's length [m], and the mass of
weights over A22 [1/m^2]."""
COUNT = 10


def outer_rod_length(length: float, l2: float) -> float:
    """Return how long the outer rod is taken to be [m]: as long as the inner one, or twice as far as its centre."""
    return max(length, 2.0 * l2)


def effect_constants(coefficients: Array, length: float, outer_length: float, carried: float = 0.0) -> Array:
    """Return the constants (10,) of a mechanism.

    Args:
        coefficients: (7,) of the model.
        length: L [m].
        outer_length: of the outer rod [m].
        carried: mass of the weights clamped to the rods, over the inertia about the cart's joint [1/m^2].
    """
    return np.concatenate([coefficients, [length, outer_length, carried]])
