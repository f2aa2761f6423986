# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether the residuals of a model are white, and uncorrelated with each other and with the cart's motion.

Residual analysis as of Box and Jenkins (Time Series Analysis, 1970, Section 8.2) and Ljung (System Identification,
1999, Section 16.6). A free swing has no input; where the cart moves, its acceleration is one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import ndtri

from cdp_ident.fit.autocorrelation import autocovariance
from cdp_ident.fit.initial_states import Fit

Array = npt.NDArray[np.float64]

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
    counted: npt.NDArray[np.bool_]
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
        residuals = list(fit.errors)
        auto = autocovariance(residuals)
        lags = min(MOST_LAGS, len(auto) - 1)
        angles = [[residual[:, [column]] for residual in residuals] for column in range(2)]
        theta1, theta2 = (_itself(auto[:, column], lags, sum(map(len, residuals))) for column in range(2))
        crosswise = _between(angles[0], angles[1], lags, zero_counts=False)
        pushed = [window.cart_acceleration[:, None] for window in fit.windows]
        moves = any(np.any(u) for u in pushed)
        cart = (_between(pushed, angles[0], lags), _between(pushed, angles[1], lags)) if moves else None
        interval = float(np.median(np.concatenate([np.diff(window.time) for window in fit.windows])))
        return cls(interval, theta1, theta2, crosswise, cart)


def _itself(auto: Array, lags: int, samples: int) -> Correlations:
    values = auto[: lags + 1] / max(float(auto[0]), np.finfo(float).tiny)
    return Correlations(values, _deviations(lags) / np.sqrt(samples), np.arange(lags + 1) > 0)


def _between(first: Sequence[Array], second: Sequence[Array], lags: int, zero_counts: bool = True) -> Correlations:
    """Return how one series is correlated with another so many samples later, both (n, 1) in each window.

    The bound is of Bartlett's formula for two unrelated series, each with its own autocorrelation (J. R. Stat. Soc.
    Suppl. 8, 1946).
    """
    total = np.zeros(2 * lags + 1)
    for a, b in zip(first, second, strict=True):
        products = np.correlate(b[:, 0], a[:, 0], mode="full")  # of lags -(n - 1) to n - 1
        shared = min(lags, len(a) - 1)
        total[lags - shared : lags + shared + 1] += products[len(a) - 1 - shared : len(a) + shared]
    own, other = autocovariance(list(first))[:, 0], autocovariance(list(second))[:, 0]
    size = max(float(np.sqrt(own[0] * other[0])), np.finfo(float).tiny)
    spread = 1.0 + 2.0 * float(own[1:] @ other[1:]) / size**2
    places = np.arange(-lags, lags + 1)
    counted = np.full(len(places), True) if zero_counts else places != 0
    bound = _deviations(int(counted.sum())) * np.sqrt(max(spread, 1.0) / sum(map(len, first)))
    return Correlations(total / size, float(bound), counted)


def _deviations(count: int) -> float:
    """Return the bound, in standard deviations, that so many numbers all keep to with probability 1 - LEVEL."""
    return float(-ndtri(LEVEL / (2 * max(count, 1))))
