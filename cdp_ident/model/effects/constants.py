"""What formulas of effects need to know of the mechanism beyond the angles: where it stands in their `constants`."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

LENGTH, OUTER_LENGTH, TOTAL_MASS, OUTER_MASS = 7, 8, 9, 10
"""Places after the seven coefficients: L [m], the outer rod's length [m], and two masses over A22 [1/m^2]."""
COUNT = 11


def effect_constants(
    coefficients: Array, length: float, outer_length: float, total_mass: float, outer_mass: float
) -> Array:
    """Return the constants (11,) of a mechanism; masses are relative to A22 [1/m^2]."""
    return np.concatenate([coefficients, [length, outer_length, total_mass, outer_mass]])
