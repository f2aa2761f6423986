"""Constants of the mechanism that formulas of effects use, and their places in the array `constants`."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

LENGTH, OUTER_LENGTH = 7, 8
"""Places after the seven coefficients: L and the outer rod's length [m]."""
COUNT = 9


def outer_rod_length(length: float, l2: float) -> float:
    """Return how long the outer rod is taken to be [m]: as long as the inner one, or twice as far as its centre."""
    return max(length, 2.0 * l2)


def effect_constants(coefficients: Array, length: float, outer_length: float) -> Array:
    """Return the constants (9,) of a mechanism: its coefficients, L and the outer rod's length [m]."""
    return np.concatenate([coefficients, [length, outer_length]])
