"""Linear regression where regressors are noisy too, errors have two components a row, and some rows are outliers.

Noise in the regressors draws estimates towards zero. What it adds to the normal equations is known from regressors that
were measured again, and is taken off (corrected least squares: Fuller, Measurement Error Models, 1987; by simulation:
Novick and Stefanski, J. Am. Stat. Assoc. 97, 2002). Outliers lose weight (Huber, Robust Statistics, 1981), and the
covariance allows for rows that overlap.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.bounded import minimum_within_limits

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_ROUNDS = 15
_OUTLIER = 2.5
"""Rows beyond so many standard deviations lose weight."""
_MEDIAN_OF_TWO, _MEDIAN_OF_ONE = 1.177, 0.6745
"""Median length of a standard normal vector of two components, and of one."""
_MOST_CORRECTED = 0.9
"""At most this share of the information in a direction is removed as noise."""
_LEAST_RATIO = 0.01
"""The smaller of the two components' scatters is at least so much of the larger: a component whose target is zero would
be fitted by unknowns that are all zero."""
_LEAST_SHARE = 1e-10


@dataclass(frozen=True)
class Regression:
    """What fits rows best."""

    values: Array
    """(n,) unknowns."""
    covariance: Array
    """(n, n) of the unknowns."""
    residuals: Array
    """(k, 2) left in each row; zero where a component does not hold."""
    weights: Array
    """(k,) of each row; 1 but for outliers."""
    scatter: Array
    """(2, 2) covariance of the residuals."""
    noise_share: float
    """Largest share of any direction of the unknowns' information that is noise in the regressors."""


def regress(
    columns: Array, target: Array, holds: Mask, lower: Array, upper: Array, overlap: int, unit: int | None = None
) -> Regression:
    """Fit columns @ values to the target, within limits.

    Args:
        columns: (1 + copies, k, 2, n) as measured, then as if measured again.
        target: (1 + copies, k, 2).
        holds: (k, 2) which components count.
        lower: (n,) lowest values.
        upper: (n,) highest values.
        overlap: how many neighbouring rows are made of overlapping samples.
        unit: the unknown to which the second component is relative, whose target is zero; None where it is not so.
            Unknowns that are all zero would fit it exactly.
    """
    any_holds: Mask = np.asarray(holds.any(axis=1))
    holds = holds[any_holds]
    # Component by component, so that each is one array.
    columns, target = np.moveaxis(columns[:, any_holds], 2, 0), np.moveaxis(target[:, any_holds], 2, 0)
    columns, target = columns * holds.T[:, None, :, None], target * holds.T[:, None]
    size: Array = np.sqrt(np.sum(columns[:, 0] ** 2, axis=(0, 1)))
    determined = size > 0
    size[~determined] = 1.0
    columns /= size
    noisy = _Equations(columns[:, 1:] - columns[:, :1], target[:, 1:] - target[:, :1])
    measured = _Equations(columns[:, 0].copy(), target[:, 0].copy())
    copies = max(target.shape[1] - 1, 1)
    values: Array = np.zeros(len(size))
    weights: Array = np.ones(len(holds))
    scatter: Array = np.eye(2)
    usual = np.where(holds.all(axis=1), _MEDIAN_OF_TWO, _MEDIAN_OF_ONE)
    for _ in range(_ROUNDS):
        unweighted = _precisions(scatter, holds)
        precision = unweighted * weights
        normal, moment = measured.relative_to(values, unit).normal(precision)
        noise, noise_moment = (of / copies for of in noisy.relative_to(values, unit).normal(precision))
        corrected, share = _take_off(normal, noise)
        before = values
        values = minimum_within_limits(corrected, moment - noise_moment, lower * size, upper * size)
        residuals = (measured.columns @ values - measured.target).T
        distance = np.sqrt(_squares(residuals, unweighted))
        median = np.median(distance / usual)
        weights = np.minimum(1.0, _OUTLIER / np.maximum(distance / max(median, 1e-300), 1e-300))
        scatter = _covariance_of(residuals, holds, weights)
        if np.allclose(values, before, rtol=1e-6, atol=1e-9 * np.abs(values).max()):
            break
    inside = (values > lower * size) & (values < upper * size)
    whitened = _whitened(residuals, _precisions(scatter, holds)) * np.sqrt(weights)[:, None]
    covariance = _covariance(corrected, whitened, inside, overlap)
    covariance[np.ix_(~determined, ~determined)] = np.diag(np.full(np.count_nonzero(~determined), np.inf))
    left = np.zeros((len(any_holds), 2))
    left[any_holds] = residuals
    weight = np.zeros(len(any_holds))
    weight[any_holds] = weights
    return Regression(values / size, covariance / np.outer(size, size), left, weight, scatter, share)


@dataclass(frozen=True)
class _Equations:
    """Columns and target, of one or several measurements."""

    columns: Array
    """(2, …, k, n) of either component."""
    target: Array
    """(2, …, k)."""

    def relative_to(self, values: Array, unit: int | None) -> "_Equations":
        """Return what is linear in the values near some (n,), the second component over one of them."""
        if unit is None or not values[unit]:
            return self
        left = self.columns[1] @ values
        columns, target = self.columns.copy(), self.target.copy()
        columns[1, ..., unit] -= left / values[unit]
        target[1] = -left
        return _Equations(columns, target)

    def normal(self, precision: Array) -> tuple[Array, Array]:
        """Return columns' precision columns (n, n) and columns' precision target (n,), summed over rows."""
        count = self.columns.shape[-1]
        of_one, of_both, of_other = precision[..., None]
        one, other = self.columns
        heavy = np.stack([of_one * one + of_both * other, of_both * one + of_other * other]).reshape(-1, count)
        return np.asarray(self.columns.reshape(-1, count).T @ heavy), np.asarray(heavy.T @ self.target.ravel())


def _precisions(scatter: Array, holds: Mask) -> Array:
    """Return the inverse covariance of each row, of the components that hold.

    It is (3, k): of the first component, of both together, and of the second one.
    """
    inverse = np.linalg.inv(scatter)
    both = holds.all(axis=1)
    of_one, of_other = (np.where(both, inverse[k, k], holds[:, k] / scatter[k, k]) for k in range(2))
    return np.stack([of_one, np.where(both, inverse[0, 1], 0.0), of_other])


def _squares(residuals: Array, precision: Array) -> Array:
    """Return the squares (k,) of residuals (k, 2) in standard deviations."""
    (one, other), (of_one, of_both, of_other) = residuals.T, precision
    return np.asarray(of_one * one**2 + 2.0 * of_both * one * other + of_other * other**2)


def _whitened(residuals: Array, precision: Array) -> Array:
    """Return residuals (k, 2) in standard deviations, made independent of each other."""
    (one, other), (of_one, of_both, of_other) = residuals.T, precision
    first = np.sqrt(of_one + 1e-300)
    slope = of_both / first
    return np.column_stack([first * one + slope * other, np.sqrt(of_other + 1e-300 - slope**2) * other])


def _covariance_of(residuals: Array, holds: Mask, weights: Array) -> Array:
    """Return the robust covariance (2, 2) of residuals (k, 2)."""
    both = holds.all(axis=1)
    sizes = np.array([_spread(residuals[holds[:, k], k]) for k in range(2)])
    floor = max(float(sizes.max()), 1e-300) * _LEAST_RATIO
    sizes = np.maximum(sizes, floor)
    a, b = (residuals[both] * np.sqrt(weights[both, None])).T
    lengths = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    correlation = np.clip(np.sum(a * b) / lengths, -0.99, 0.99) if lengths > 0 else 0.0
    return np.asarray(np.outer(sizes, sizes) * [[1.0, correlation], [correlation, 1.0]])


def _spread(values: Array) -> float:
    return float(np.median(np.abs(values))) / _MEDIAN_OF_ONE if len(values) else 0.0


def _take_off(normal: Array, noise: Array) -> tuple[Array, float]:
    """Return the normal matrix without the noise's part in it, and the noise's largest share of any direction."""
    size = np.trace(normal) / len(normal)
    root = np.linalg.cholesky(normal + max(size, 1e-300) * _LEAST_SHARE * np.eye(len(normal)))
    half = np.linalg.solve(root, noise)
    shares, directions = np.linalg.eigh(np.linalg.solve(root, half.T))
    kept = 1.0 - np.minimum(shares, _MOST_CORRECTED)
    turned = root @ directions
    return (turned * kept) @ turned.T, float(shares.max())


def _covariance(normal: Array, whitened_residuals: Array, inside: Mask, overlap: int) -> Array:
    """Return the covariance of the unknowns.

    Unknowns at a limit have none; those that do not enter the rows have infinite variances. The errors of overlapping
    rows are correlated: the variances grow by the sum of the residuals' autocorrelation.
    """
    power = float(np.sum(whitened_residuals**2))
    alike = sum(float(np.sum(whitened_residuals[lag:] * whitened_residuals[:-lag])) for lag in range(1, overlap + 1))
    fewer = max(1.0, 1.0 + 2.0 * alike / power) if power > 0 else 1.0
    free = np.flatnonzero(inside)
    independent = np.count_nonzero(whitened_residuals) / overlap
    fewer *= independent / max(independent - len(free), 1.0)
    covariance = np.zeros((len(inside), len(inside)))
    covariance[np.ix_(free, free)] = fewer * np.linalg.inv(normal[np.ix_(free, free)])
    return covariance
