# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a quantity changed, and the probability of such a change by chance.

The series x_i, with standard deviations s_i up to one common factor, has one mean until an instant and another from
then on. At a given instant the generalised likelihood ratio, the factor being unknown, grows with

    F = (difference of the weighted means)^2 / (its variance), weights 1/s_i^2, the variance scaled by what remains,

which has Fisher's distribution with 1 and n - 2 degrees of freedom where nothing changed. The largest over all
instants is compared with that distribution by Bonferroni's inequality (Worsley, Journal of the American Statistical
Association 74, 1979; Basseville and Nikiforov, Detection of Abrupt Changes, 1993, chapter 2). Both sides of a change
are then looked at in the same way, as two series together (binary segmentation: Vostrikova, Soviet Mathematics Doklady
24, 1981).

The common factor is Birge's ratio (Physical Review 40, 1932): from day to day estimates scatter by more than the noise
within a day explains, and by how much more is estimated from the series alone. The level of the test holds for any such
factor; therefore a few values show only large changes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import fdtrc

Array = npt.NDArray[np.float64]

FEWEST = 4
"""Fewest values for a test."""


@dataclass(frozen=True)
class Change:
    """Where a series changed."""

    index: int
    """Of the first value after it."""
    p_value: float
    """Probability of one at least as clear anywhere in the series, or in any of the `tests`, if nothing changed."""


@dataclass(frozen=True)
class Mean:
    """Of values that belong together."""

    value: float
    std: float
    """From the scatter of the values; its own standard deviation where there is one value."""


def changes(values: Array, std: Array, level: float, tests: int = 1) -> list[Change]:
    """Return where a series changed, in order.

    Args:
        values: (n,) in the order of time.
        std: (n,) their standard deviations, up to a common factor.
        level: only changes whose `p_value` is below this are returned.
        tests: how many series are tested together; the level is the probability of a false alarm in any of them.
    """
    return _changes(np.asarray(values, dtype=float), np.asarray(std, dtype=float) ** -2.0, level, tests, 0)


def _changes(values: Array, weights: Array, level: float, tests: int, first: int) -> list[Change]:
    if len(values) < FEWEST:
        return []
    index, p_value = _clearest(values, weights)
    p_value = min(1.0, p_value * (len(values) - 1) * tests)
    if p_value >= level:
        return []
    return [
        *_changes(values[:index], weights[:index], level, 2 * tests, first),
        Change(first + index, p_value),
        *_changes(values[index:], weights[index:], level, 2 * tests, first + index),
    ]


def _clearest(values: Array, weights: Array) -> tuple[int, float]:
    """Return the instant at which a change is clearest, and its p-value at that instant alone."""
    centred = values - np.average(values, weights=weights)
    before = np.cumsum(weights)[:-1]
    after = weights.sum() - before
    moment = np.cumsum(weights * centred)[:-1]
    # The weighted means are moment / before and -moment / after.
    between = moment**2 * (1.0 / before + 1.0 / after)
    index = int(np.argmax(between))
    total = float(np.sum(weights * centred**2))
    if total <= 0.0:
        return index + 1, 1.0
    freedom = len(values) - 2
    remaining = max(total - float(between[index]), np.finfo(float).eps * total)
    return index + 1, float(fdtrc(1, freedom, between[index] / (remaining / freedom)))


def appearance(found: Sequence[bool], level: float, tests: int = 1) -> Change | None:
    """Return where something began to be found, or ceased to be, more often than before.

    Fisher's exact test of each instant, of both sides, the clearest by Bonferroni's inequality; arguments as for
    `changes`.
    """
    count = len(found)
    if count < FEWEST:
        return None
    before = np.cumsum(found)[:-1]
    # Loading it takes as long as all else of a survey.
    from scipy.stats import hypergeom  # noqa: PLC0415

    drawn = hypergeom(count, sum(found), np.arange(1, count))
    p_values = 2.0 * np.minimum(drawn.cdf(before), drawn.sf(before - 1))
    index = int(np.argmin(p_values))
    p_value = min(1.0, float(p_values[index]) * (count - 1) * tests)
    return Change(index + 1, p_value) if p_value < level else None


def mean(values: Array, std: Array) -> Mean:
    """Return the weighted mean of values (n,) that belong together, with standard deviations (n,)."""
    weights = np.asarray(std, dtype=float) ** -2.0
    value = float(np.average(values, weights=weights))
    scatter = float(np.sum(weights * (values - value) ** 2) / (len(values) - 1)) if len(values) > 1 else 1.0
    return Mean(value, float(np.sqrt(scatter / weights.sum())))
