# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether the residuals of a model are white, and uncorrelated with each other and with the cart's motion.

Residual analysis as of Box and Jenkins (Time Series Analysis, 1970, Section 8.2) and Ljung (System Identification,
1999, Section 16.6). A free swing has no input; where the cart moves, its acceleration is one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.special import ndtri

from cdp_ident.arrays import Array, Mask
from cdp_ident.fit.initial_states import Fit

MOST_LAGS = 25
"""Samples, either way."""
LEVEL = 0.01
"""Probability that chance brings any of the lags beyond its bounds (Bonferroni)."""


@dataclass(frozen=True)
class Correlations:
    """Correlations between two series, by lag."""

    values: Array
    """(lags,) from -1 to 1."""
    bound: float
    """Uncorrelated series stay within it at all lags with a probability of 99 %."""
    counted: Mask
    """(lags,) which of them count: not lag 0 of a series with itself."""

    @property
    def related(self) -> bool:
        """Whether a lag is beyond the bound."""
        return bool(np.any(np.abs(self.values[self.counted]) > self.bound))


@dataclass(frozen=True)
class Whiteness:
    """Correlations of both angles' residuals with themselves, with each other, and with the cart's acceleration."""

    interval: float
    """Between samples [s]."""
    theta1: Correlations
    """With itself, at the lags 0, 1, …"""
    theta2: Correlations
    crosswise: Correlations
    """Of theta1 with theta2 so many samples later, from the most negative lag on.

    Lag 0 does not count: with an outer encoder on the inner rod, both angles contain the inner encoder's noise.
    """
    cart: tuple[Correlations, Correlations] | None
    """Of the cart's acceleration with theta1 and with theta2 so many samples later; None where the cart is at rest."""

    @property
    def white(self) -> bool:
        """Whether neither angle's residuals are correlated in time."""
        return not (self.theta1.related or self.theta2.related)

    @classmethod
    def of(cls, fit: Fit) -> "Whiteness":
        """Take it from the residuals of all windows together."""
        theta1, theta2 = ([error[:, column] for error in fit.errors] for column in range(2))
        pushed = [window.cart_acceleration for window in fit.windows]
        moves = any(np.any(u) for u in pushed)
        cart = (_between(pushed, theta1), _between(pushed, theta2)) if moves else None
        interval = float(np.median(np.concatenate([np.diff(window.time) for window in fit.windows])))
        return cls(interval, _itself(theta1), _itself(theta2), _between(theta1, theta2, zero_counts=False), cart)


def _covariance(first: Sequence[Array], second: Sequence[Array]) -> tuple[Array, int]:
    """Return the sums of products of one series with another so many samples later, and where those of lag 0 are.

    Both are (n,) in each window. Lags go up to a quarter of the longest window, either way.
    """
    most = max(map(len, first)) // 4
    total = np.zeros(2 * most + 1)
    for one, other in zip(first, second, strict=True):
        padded = next_fast_len(len(one) + most)
        products = irfft(np.conj(rfft(one, padded)) * rfft(other, padded), padded)
        total += products[np.arange(-most, most + 1)]
    return total, most


def _itself(series: Sequence[Array]) -> Correlations:
    products, zero = _covariance(series, series)
    lags = min(MOST_LAGS, zero)
    values = products[zero : zero + lags + 1] / max(float(products[zero]), np.finfo(float).tiny)
    return Correlations(values, _deviations(lags) / np.sqrt(sum(map(len, series))), np.arange(lags + 1) > 0)


def _between(first: Sequence[Array], second: Sequence[Array], zero_counts: bool = True) -> Correlations:
    """Return how one series is correlated with another so many samples later.

    The bound is of Bartlett's formula for two unrelated series, each with its own autocorrelation (J. R. Stat. Soc.
    Suppl. 8, 1946).
    """
    (products, zero), (own, _), (other, _) = (
        _covariance(*pair) for pair in ((first, second), (first, first), (second, second))
    )
    size = max(float(np.sqrt(own[zero] * other[zero])), np.finfo(float).tiny)
    spread = 1.0 + 2.0 * float(own[zero + 1 :] @ other[zero + 1 :]) / size**2
    lags = min(MOST_LAGS, zero)
    places = np.arange(-lags, lags + 1)
    counted = np.full(len(places), True) if zero_counts else places != 0
    bound = _deviations(int(counted.sum())) * np.sqrt(max(spread, 1.0) / sum(map(len, first)))
    return Correlations(products[zero + places] / size, float(bound), counted)


def _deviations(count: int) -> float:
    """Return the bound, in standard deviations, that so many numbers all keep to with probability 1 - LEVEL."""
    return float(-ndtri(LEVEL / (2 * max(count, 1))))
