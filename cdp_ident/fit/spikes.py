"""Single samples that a fit shows to be no measurements: errors of 4 standard deviations and more among small ones.

What stands out from the samples around it by 8 is left out before anything is fitted (`trial/outliers.py`). A fit that
leaves nothing but noise shows smaller ones, for it knows the motion from all samples. Neighbours tell a spike from an
event that the model lacks, and from noise that is remembered: of these, all samples around are off.
"""

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_LIMIT = 4.0
"""In standard deviations, of both errors together: of white noise, one sample in 3000 is beyond."""
_BESIDE = 4
"""Samples on either side that must be of usual size in the median."""
_USUAL = 3.0
"""Times the median square over all."""
_MEDIAN = 2.0 * np.log(2.0)
"""Median of the sum of squares of two standard normal numbers."""


def spikes(errors: list[Array]) -> list[Mask]:
    """Return which samples (n,) of each window are spikes, given their errors (n, 2), independent and of equal size."""
    squares = [np.sum(error**2, axis=1) for error in errors]
    usual = float(np.median(np.concatenate(squares)))
    return [(of > _LIMIT**2 * usual / _MEDIAN) & (_around(of) < _USUAL * usual) for of in squares]


def _around(squares: Array) -> Array:
    """Return the median (n,) of the squares (n,) beside each, at the ends mirrored; infinite for too few."""
    padded = (
        np.pad(squares, _BESIDE, mode="reflect")
        if len(squares) > _BESIDE
        else np.full(len(squares) + 2 * _BESIDE, np.inf)
    )
    around = np.delete(sliding_window_view(padded, 2 * _BESIDE + 1), _BESIDE, axis=1)
    return np.asarray(np.median(around, axis=1))
