"""Autoregressive processes, sample by sample: x_t = c_1 x_(t-1) + … + c_p x_(t-p) + e_t.

`scipy.signal.lfilter` does the same in the same time, but to load `scipy.signal` takes longer than all else of scipy.
"""

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_banded

Array = npt.NDArray[np.float64]


def carried_on(coefficients: Array, new: Array) -> Array:
    """Return the process x (n, …) with coefficients (p,) that is zero before what is new in each sample, e (n, …)."""
    order = len(coefficients)
    if not new.size or not order:
        return new.copy()  # there is nothing to solve
    # What is new is a lower triangle with few diagonals times the process.
    diagonals = np.empty((order + 1, len(new)))
    diagonals[0], diagonals[1:] = 1.0, -coefficients[:, None]
    return np.asarray(solve_banded((order, 0), diagonals, new.reshape(len(new), -1))).reshape(new.shape)
