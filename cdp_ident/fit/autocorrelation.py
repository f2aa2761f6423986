# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far the residuals of a fit are correlated in time."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.fft import irfft, next_fast_len, rfft

Array = npt.NDArray[np.float64]

_WHITE = 2.6
"""99 % limits of the autocorrelations of white noise, times the root of the number of samples."""
_QUIET = 3
"""The correlation ends where so many lags in a row are within these limits."""


def correlation_length(residuals: Sequence[Array]) -> int:
    """Return the lag, in samples, up to which residuals (n, k) of windows are correlated; 0 where they are white."""
    products = autocovariance(residuals)
    limit = _WHITE / np.sqrt(sum(len(residual) for residual in residuals))
    quiet = np.max(np.abs(products[1:] / np.maximum(products[0], np.finfo(float).tiny)), axis=1) <= limit
    ends = np.convolve(quiet, np.ones(_QUIET, dtype=int), mode="valid") == _QUIET
    return int(np.argmax(ends)) if np.any(ends) else int(np.max(np.flatnonzero(~quiet), initial=-1)) + 1


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
