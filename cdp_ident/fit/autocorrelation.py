"""How far the residuals of a fit are correlated in time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.fft import irfft, next_fast_len, rfft

Array = npt.NDArray[np.float64]

_WHITE = 2.6
"""99 % limits of the autocorrelations of white noise, times the root of the number of samples."""
_QUIET = 3
"""The correlation ends where so many lags in a row are within these limits."""


@dataclass(frozen=True)
class Autocorrelation:
    """How far residuals are correlated in time."""

    length: int
    """Correlation length: the lag, in samples, up to which they are correlated; 0 where they are white."""
    integrated_time: float
    """Integrated autocorrelation time, in samples: n residuals carry as much information as n over this number of
    independent ones; 1 for white residuals. It is 1 plus twice the sum of the autocorrelations up to the correlation
    length, with Bartlett's weights."""

    @classmethod
    def of(cls, residuals: Sequence[Array]) -> "Autocorrelation":
        """Take it from the residuals (n, 2) of windows [rad]."""
        products = autocovariance(residuals)
        limit = _WHITE / np.sqrt(sum(len(residual) for residual in residuals))
        tiny = np.finfo(float).tiny
        quiet = np.max(np.abs(products[1:] / np.maximum(products[0], tiny)), axis=1) <= limit
        ends = np.convolve(quiet, np.ones(_QUIET, dtype=int), mode="valid") == _QUIET
        length = int(np.argmax(ends)) if np.any(ends) else int(np.max(np.flatnonzero(~quiet), initial=-1)) + 1
        weights = 1.0 - np.arange(1, length + 1) / (length + 1.0)
        both = products.sum(axis=1)
        total = 1.0 + 2.0 * float(weights @ both[1 : length + 1]) / max(float(both[0]), tiny)
        return cls(length, max(total, 1.0))


def autocovariance(residuals: Sequence[Array]) -> Array:
    """Return the sums (lags, 2) of products of residuals so many samples apart in one window, from lag 0 on [rad^2].

    Lags go up to a quarter of the longest window.
    """
    lags = max(map(len, residuals)) // 4 + 1
    total = np.zeros((lags, 2))
    for residual in residuals:
        padded = next_fast_len(len(residual) + lags)
        power = np.abs(rfft(residual, padded, axis=0)) ** 2
        total += irfft(power, padded, axis=0)[:lags]
    return total
