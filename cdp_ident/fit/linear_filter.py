"""Autoregressive processes, sample by sample: x_t = c_1 x_(t-1) + … + c_p x_(t-p) + e_t.

`scipy.signal.lfilter` does the same in the same time, but to load `scipy.signal` takes longer than all else of scipy.
"""

import numpy as np
import numpy.typing as npt
from scipy.linalg.lapack import dtbtrs

Array = npt.NDArray[np.float64]


def carried_on(coefficients: Array, new: Array) -> Array:
    """Return the process x (n, …) with coefficients (p,) that is zero before what is new in each sample, e (n, …)."""
    if not new.size or not len(coefficients):
        return new.copy()  # LAPACK asks for a column at least
    # What is new is a lower triangle with few diagonals times the process.
    diagonals = np.empty((len(coefficients) + 1, len(new)), order="F")
    diagonals[0], diagonals[1:] = 1.0, -coefficients[:, None]
    process, _ = dtbtrs(diagonals, new.reshape(len(new), -1), uplo="L", diag="U")
    return np.asarray(process).reshape(new.shape)


def new_in(coefficients: Array, process: Array) -> Array:
    """Return what is new in each sample (n - p, …) of a process (n, …) with coefficients (p,), but for the first p."""
    count = len(coefficients)
    new = process[count:].copy()
    for lag, coefficient in enumerate(coefficients, start=1):
        new -= coefficient * process[count - lag : len(process) - lag]
    return new
