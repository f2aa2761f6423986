"""Noise that is remembered: the autoregressive process that a fit's residuals are taken to come from.

x_t = c_1 x_(t-1) + … + c_p x_(t-p) + e_t, of each angle, e white. Its coefficients are those of least squares, their
number is that of Bayes's information criterion. Residuals are less correlated than the noise that they come from, for
every window's initial state and the common unknowns follow it where it is slow. So what these take away of the products
of samples, under the process that was found, is given back, and the process is found again.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.linear_filter import carried_on, new_in

Array = npt.NDArray[np.float64]

_MOST_COEFFICIENTS = 8
_SLOWEST = 0.995
"""A process that keeps more than this share from one sample to the next is no noise."""
_FORGOTTEN = 1e-3
"""What happened before a window counts until so little of it is left."""
_CORRECTIONS = 3
"""Each is smaller than the one before by the share of the products that a fit takes away."""


@dataclass(frozen=True)
class Process:
    """An autoregressive process."""

    coefficients: Array
    """(p,) share of the sample before in the present one, of the one before that, and so on; none for white noise."""
    variance: float
    """Of what is new in each sample [rad^2]."""
    loss: float = 1.0
    """Share of that variance which a fit leaves in the residuals."""

    @classmethod
    def of(cls, products: Array, count: int) -> "Process":
        """Take it from mean products (lags, lags) of samples so many before one [rad^2], with so many coefficients."""
        first, others = products[1 : count + 1, 0], products[1 : count + 1, 1 : count + 1]
        coefficients = np.asarray(np.linalg.solve(others, first), dtype=np.float64)
        found = cls(coefficients, float(products[0, 0] - first @ coefficients))
        if found.slowest <= _SLOWEST:
            return found
        faded = coefficients * (_SLOWEST / found.slowest) ** np.arange(1, count + 1)
        return cls(faded, found._new_in(products, faded))

    @staticmethod
    def _new_in(products: Array, coefficients: Array) -> float:
        """Return the mean square of what is new in samples with these products, under some coefficients [rad^2]."""
        kept = np.concatenate([[1.0], -coefficients])
        return float(kept @ products[: len(kept), : len(kept)] @ kept)

    @cached_property
    def slowest(self) -> float:
        """Share of what the process keeps from one sample to the next, in the end."""
        return float(np.max(np.abs(np.roots(np.concatenate([[1.0], -self.coefficients]))), initial=0.0))

    @cached_property
    def lead(self) -> int:
        """So many samples before a window still count."""
        return int(np.log(_FORGOTTEN) / np.log(self.slowest)) + 1 if self.slowest > 0.0 else 0

    def new_in(self, rows: Array) -> Array:
        """Return what is new in each sample (n, …), which is not known of the first p."""
        return new_in(self.coefficients, rows)

    def spread_back(self, rows: Array) -> Array:
        """Return the weights (lead + n, …) with which what was new in each sample is in the sum of noise times rows."""
        before = np.zeros((self.lead, *rows.shape[1:]))
        return carried_on(self.coefficients, np.concatenate([before, rows])[::-1])[::-1]

    def covariance_times(self, rows: Array) -> Array:
        """Return the noise's covariance times rows (n, …) [rad^2]."""
        carried = carried_on(self.coefficients, self.spread_back(rows))
        return np.asarray(self.variance * carried[self.lead :])


@dataclass(frozen=True)
class Followed:
    """Orthonormal changes of windows by what is fitted; those of one window at a time are in memory."""

    explained: Sequence[Array]
    """(n, 2, states) orthonormal changes of each window by its initial state."""
    by_unknowns: Sequence[Array]
    """(n, 2, unknowns) changes by common unknowns, orthogonal to these."""
    factor: Array
    """(unknowns, k) makes these orthonormal over all windows."""

    @property
    def states(self) -> int:
        """Number of changes by a window's initial state."""
        return int(self.explained[0].shape[2])

    def __iter__(self) -> Iterator[Array]:
        """Yield the changes (n, 2, states + k) of each window."""
        for by_state, by_unknown in zip(self.explained, self.by_unknowns, strict=True):
            yield np.concatenate([by_state, by_unknown @ self.factor], axis=2)


def autoregressive(residuals: Sequence[Array], sizes: Sequence[Array], followed: Followed) -> Process:
    """Return the process that leaves the residuals of a fit.

    Args:
        residuals: (n, 2) of each window [rad].
        sizes: (n, 1) of noise in each sample over that of most; one where samples of a rest are not counted as one.
        followed: what the fit follows of noise.
    """
    lags = min(_MOST_COEFFICIENTS, min(map(len, residuals)) // 2)
    samples = 2.0 * float(sum(np.sum(size[lags:] ** 2) for size in sizes))
    measured = np.sum([_products(residual, residual, lags) for residual in residuals], axis=0) / samples
    if measured[0, 0] == 0.0:
        return Process(np.empty(0), 0.0)
    found = [Process.of(measured, count) for count in range(lags + 1)]
    criteria = [samples * np.log(p.variance) + np.log(samples) * len(p.coefficients) for p in found]
    process = found[int(np.argmin(criteria))]
    count = len(process.coefficients)
    if count == 0:
        return white(residuals, sizes, followed)
    for _ in range(_CORRECTIONS):
        corrected = Process.of(measured + _taken_away(process, followed, lags) / samples, count)
        if not corrected.variance > 0.0:
            break  # what the model lacks, and no process: what is said to be taken away is more than there is
        process = corrected
    return replace(process, loss=Process._new_in(measured, process.coefficients) / process.variance)


def white(residuals: Sequence[Array], sizes: Sequence[Array], followed: Followed) -> Process:
    """Return the process without a memory that leaves the residuals of a fit; arguments as for `autoregressive`."""
    samples = 2.0 * float(sum(np.sum(size**2) for size in sizes))
    left = max(1.0 - float(sum(np.sum(changes**2) for changes in followed)) / samples, 1.0 / samples)
    return Process(np.empty(0), float(sum(np.sum(residual**2) for residual in residuals)) / samples / left, left)


def _taken_away(process: Process, followed: Followed, lags: int) -> Array:
    """Return what a fit takes away of the sums of products (lags + 1, lags + 1) of a process's samples [rad^2]."""
    total, squares = np.zeros((lags + 1, lags + 1)), []
    for changes in followed:
        carried = process.covariance_times(changes)
        squares.append(np.einsum("nri,nrj->ij", changes, carried))
        across = _products(changes, carried, lags)
        total += across + across.T
    # The change of a common unknown is due to the noise of all windows.
    common = slice(followed.states, None)
    of_unknowns = np.sum([square[common, common] for square in squares], axis=0)
    for changes, square in zip(followed, squares, strict=True):
        square[common, common] = of_unknowns
        total -= _products(changes @ square, changes, lags)
    return total


def _products(one: Array, other: Array, lags: int) -> Array:
    """Return the sums (lags + 1, lags + 1) of products of rows (n, …) so many samples before one with others."""
    first, second = (of.reshape(len(of), -1) for of in (one, other))
    now, end = slice(lags, None), len(first)
    sums = np.empty((lags + 1, lags + 1))
    for lag in range(lags + 1):
        before = slice(lags - lag, end - lag)
        sums[0, lag], sums[lag, 0] = np.vdot(first[now], second[before]), np.vdot(first[before], second[now])
    # One sample earlier, a sum gains its first product and loses its last.
    gained = first[:lags][::-1] @ second[:lags][::-1].T
    lost = first[end - lags :][::-1] @ second[end - lags :][::-1].T
    for lag in range(lags):
        sums[lag + 1, 1:] = sums[lag, :-1] + gained[lag] - lost[lag]
    return sums
