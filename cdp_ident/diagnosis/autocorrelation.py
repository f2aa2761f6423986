"""How far the residuals of a fit are correlated in time."""

import numpy as np
import numpy.typing as npt
from scipy.fft import irfft, next_fast_len, rfft

from cdp_ident.fit.refinement import Fit

Array = npt.NDArray[np.float64]


def integrated_autocorrelation_time(fit: Fit) -> float:
    """Return the residuals' integrated autocorrelation time in samples: 1 for white ones.

    n residuals say as much as n over this number of independent ones: 1 plus twice the sum of the autocorrelations
    up to the correlation length, with Bartlett's weights.
    """
    lags = correlation_length(fit)
    products = autocovariance(fit).sum(axis=1)
    weights = 1.0 - np.arange(1, lags + 1) / (lags + 1.0)
    total = 1.0 + 2.0 * float(weights @ products[1 : lags + 1]) / max(products[0], np.finfo(float).tiny)
    return max(total, 1.0)


def correlation_length(fit: Fit) -> int:
    """Return the lag, in samples, up to which the residuals are correlated; 0 where they are white.

    Lags are counted until three in a row have autocorrelations inside the 99 % limits of white noise.
    """
    products = autocovariance(fit)
    count = sum(len(residual) for residual in fit.residuals)
    correlation = products[1:] / np.maximum(products[0], np.finfo(float).tiny)
    loud = np.max(np.abs(correlation), axis=1) > 2.6 / np.sqrt(count)
    quiet, last = 0, 0
    for lag, is_loud in enumerate(loud, start=1):
        if is_loud:
            quiet, last = 0, lag
        else:
            quiet += 1
            if quiet == 3:
                break
    return last


def autocovariance(fit: Fit) -> Array:
    """Return the sums (lags, 2) of products of residuals so many samples apart in one window, from lag 0 on [rad^2].

    Lags go up to a quarter of the longest window.
    """
    lags = max(len(residual) for residual in fit.residuals) // 4 + 1
    total = np.zeros((lags, 2))
    for residual in fit.residuals:
        padded = next_fast_len(len(residual) + lags)
        power = np.abs(rfft(residual, padded, axis=0)) ** 2
        total += irfft(power, padded, axis=0)[:lags]
    return total
