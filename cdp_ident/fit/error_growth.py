"""How errors of a state grow along a motion: the equations of motion linearised along it (compiled)."""

import numpy as np
import numpy.typing as npt

from cdp_ident.machine.compilation import compiled
from cdp_ident.model.motions import jacobians_at

Array = npt.NDArray[np.float64]


def steps_until(
    states: Array,
    coefficients: Array,
    spacing: float,
    begins: npt.NDArray[np.int64],
    error: Array,
    limits: Array,
    most: int,
) -> npt.NDArray[np.int64]:
    """Return after how many steps (k,) an error of the state is beyond a limit; 0 where it never is.

    Args:
        states: (n, 4) theta1, theta2 [rad], omega1, omega2 [rad/s] of the motion, evenly spaced, cart at rest.
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        spacing: of the states [s].
        begins: (k,) indices of the states that have the error.
        error: (4,) its standard deviations, independent of each other.
        limits: (2,) of the standard deviation of each angle [rad].
        most: steps after which nobody asks.
    """
    lasts = np.zeros(len(begins), dtype=np.int64)
    turns = jacobians_at(coefficients, states[:-1])
    _steps_until(turns, spacing, begins, error, limits, most, lasts)
    return lasts


@compiled
def _steps_until(turns, spacing, begins, error, limits, most, lasts):
    count = len(turns)
    errors, term, next_term = np.empty((4, 4)), np.empty((4, 4)), np.empty((4, 4))
    for b in range(len(begins)):
        for row in range(4):
            for column in range(4):
                errors[row, column] = error[row] if row == column else 0.0
        for k in range(begins[b], min(begins[b] + most, count)):
            # In time units of a state with speeds of about one, three terms of the exponential hold to a thousandth.
            for row in range(4):
                for column in range(4):
                    term[row, column] = errors[row, column]
            for order in range(1, 4):
                share = spacing / order
                for column in range(4):
                    next_term[0, column], next_term[1, column] = share * term[2, column], share * term[3, column]
                    for row in range(2):
                        total = 0.0
                        for by in range(4):
                            total += turns[k, row, by] * term[by, column]
                        next_term[2 + row, column] = share * total
                for row in range(4):
                    for column in range(4):
                        term[row, column] = next_term[row, column]
                        errors[row, column] += next_term[row, column]
            lost = False
            for row in range(2):
                variance = 0.0
                for column in range(4):
                    variance += errors[row, column] * errors[row, column]
                lost = lost or variance > limits[row] * limits[row]
            if lost:
                lasts[b] = k + 1 - begins[b]
                break
