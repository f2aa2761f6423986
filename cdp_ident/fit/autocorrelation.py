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
_PAST_THE_END = 4
"""A decay is compared with autocorrelations up to so many times the correlation length, and a few lags more."""
_MORE_LAGS = 8
_MISFIT = 4.0
"""Largest mean squared deviation of autocorrelations from those of a process, over their variance. Deviations at
neighbouring lags are alike, and a fit takes a little away at all of them."""
_CUSP = 0.25
"""The share of what is remembered may be found larger than 1 by so much."""
_DECAYS = 100
"""Decay times that are tried."""


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


def long_run_products(terms: Array, lags: int) -> Array:
    """Return the sum (k, k) of the products of terms (n, k) that are up to so many lags apart, with Bartlett's weights.

    It estimates the covariance of the terms' sum (Newey and West, Econometrica 55, 1987), and is that of the running
    sums of lags + 1 terms, over lags + 1.
    """
    totals = np.concatenate([np.zeros((1, terms.shape[1])), np.cumsum(terms, axis=0)])
    ends = np.arange(1, len(terms) + lags + 1)
    running = totals[np.minimum(ends, len(terms))] - totals[np.maximum(ends - lags - 1, 0)]
    return np.asarray(running.T @ running / (lags + 1))


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


def decay_time(residuals: Sequence[Array], length: int) -> float:
    """Return within how many samples noise with a memory falls to 1/e; infinite where residuals are no such noise.

    Such noise is a first-order autoregressive process with white noise added: its autocorrelations at the lags k > 0
    are A phi^k, with A at most 1. They have a cusp at lag 0, while those of what a model lacks, which is as smooth as
    the motion, are level there and pass through zero later.

    Args:
        residuals: (n, 2) of windows [rad].
        length: their correlation length [samples].
    """
    products = autocovariance(residuals)
    lags = min(_PAST_THE_END * length + _MORE_LAGS, len(products) - 1)
    correlations = products[1 : lags + 1] / np.maximum(products[0], np.finfo(float).tiny)
    return max(_decay_time(of_angle, sum(map(len, residuals))) for of_angle in correlations.T)


def _decay_time(correlations: Array, samples: int) -> float:
    """Return the same of one angle, given its autocorrelations from lag 1 on."""
    lags = np.arange(1, len(correlations) + 1)
    decays = np.exp(-1.0 / np.geomspace(0.1, len(lags), _DECAYS))[:, None] ** lags
    shares = np.maximum(decays @ correlations / np.sum(decays**2, axis=1), 0.0)
    deviations = np.mean((correlations - shares[:, None] * decays) ** 2, axis=1)
    best = int(np.argmin(deviations))
    # Bartlett's variance of autocorrelations far from lag 0.
    variance = (1.0 + 2.0 * float(np.sum((shares[best] * decays[best]) ** 2))) / samples
    is_noise = deviations[best] < _MISFIT * variance and shares[best] < 1.0 + _CUSP
    return -1.0 / float(np.log(decays[best, 0])) if is_noise else np.inf
