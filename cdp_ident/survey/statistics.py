# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a quantity changed, and which rig differs: tests of series whose scatter is known up to one factor.

Values x_i have standard deviations s_i up to a common factor, which is Birge's ratio (Physical Review 40, 1932): from
day to day estimates scatter by more than the noise within a day explains, and by how much more is estimated from the
series alone. The level of a test holds for any such factor; therefore a few values show only large changes. What is
clearest of several is compared with chance by Bonferroni's inequality.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtrc, stdtr

from cdp_ident.arrays import Array, Rows

FEWEST = 4
"""Fewest values for a test of changes."""


@dataclass(frozen=True)
class Series(Rows):
    """Values of one quantity, in the order of time."""

    values: Array
    """(n,)"""
    std: Array
    """(n,) their standard deviations, up to a common factor."""

    def __len__(self) -> int:
        return len(self.values)

    @property
    def weights(self) -> Array:
        """(n,) of its values."""
        return self.std**-2.0

    @property
    def mean(self) -> float:
        """The weighted mean."""
        return float(np.average(self.values, weights=self.weights))

    @property
    def squares(self) -> float:
        """The weighted sum of squares about it."""
        return float(np.sum(self.weights * (self.values - self.mean) ** 2))

    @property
    def std_of_mean(self) -> float:
        """From the scatter of the values; its own standard deviation where there is one value."""
        scatter = self.squares / (len(self) - 1) if len(self) > 1 else 1.0
        return float(np.sqrt(scatter / self.weights.sum()))


@dataclass(frozen=True)
class Change:
    """Where a series changed."""

    index: int
    """Of the first value after it."""
    p_value: float
    """Probability of one at least as clear anywhere in the series, or in any of the `tests`, if nothing changed."""


def changes(series: Series, level: float, tests: int = 1, first: int = 0) -> list[Change]:
    """Return where a series changed, in order.

    At a given instant the generalised likelihood ratio of one mean until then and another from then on, the factor
    being unknown, grows with

        F = (difference of the weighted means)^2 / (its variance), the variance scaled by what remains,

    which has Fisher's distribution with 1 and n - 2 degrees of freedom where nothing changed. The largest over all
    instants is compared with that distribution by Bonferroni's inequality (Worsley, Journal of the American Statistical
    Association 74, 1979; Basseville and Nikiforov, Detection of Abrupt Changes, 1993, chapter 2). Both sides of a
    change are then looked at in the same way, as two series together (binary segmentation: Vostrikova, Soviet
    Mathematics Doklady 24, 1981).

    Args:
        series: what may have changed.
        level: only changes whose `p_value` is below this are returned.
        tests: how many series are tested together; the level is the probability of a false alarm in any of them.
        first: index of its first value in the whole series.
    """
    if len(series) < FEWEST:
        return []
    index, p_value = _clearest(series)
    p_value = min(1.0, p_value * (len(series) - 1) * tests)
    if p_value >= level:
        return []
    return [
        *changes(series[:index], level, 2 * tests, first),
        Change(first + index, p_value),
        *changes(series[index:], level, 2 * tests, first + index),
    ]


def _clearest(series: Series) -> tuple[int, float]:
    """Return the instant at which a change is clearest, and its p-value at that instant alone."""
    weights = series.weights
    before = np.cumsum(weights)[:-1]
    after = weights.sum() - before
    moment = np.cumsum(weights * (series.values - series.mean))[:-1]
    # The weighted means are moment / before and -moment / after.
    between = moment**2 * (1.0 / before + 1.0 / after)
    index, total = int(np.argmax(between)), series.squares
    if total <= 0.0:
        return index + 1, 1.0
    freedom = len(series) - 2
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


@dataclass(frozen=True)
class Difference:
    """A rig that differs from others."""

    rig: str
    others: tuple[str, ...]
    """Those that remain when rigs that differ more are left out."""
    value: float
    """Its mean; `others_value` is that of the others."""
    others_value: float
    std: float
    """Of the difference of the two."""
    p_value: float = 1.0

    @property
    def deviations(self) -> float:
        """The difference, in standard deviations."""
        return abs(self.value - self.others_value) / self.std if self.std > 0.0 else 0.0


def differing(rigs: Mapping[str, Series], level: float, tests: int = 1) -> list[Difference]:
    """Return the rigs that differ from the others, the one that differs most first.

    The rig whose weighted mean is farthest from that of all others, in standard deviations, is taken out while it is
    farther than chance would have it, and the rest are compared again. The factor of the standard deviations is
    estimated from the scatter within the rigs; differences have Student's distribution then, by Bonferroni's inequality
    for the farthest of several. Of two rigs that remain, the second differs from the first.

    Args:
        rigs: values of each rig, which belong together.
        level: a difference whose `p_value` is not below this is none.
        tests: how many quantities are compared together.
    """
    freedom = sum(len(series) - 1 for series in rigs.values())
    if freedom < 1:
        return []
    scatter = sum(series.squares for series in rigs.values()) / freedom
    left, found = dict(rigs), list[Difference]()
    while len(left) > 1:
        compared = [_against_others(rig, left, scatter) for rig in left]
        farthest = max(reversed(compared), key=lambda difference: difference.deviations)
        pairs = len(left) if len(left) > 2 else 1
        p_value = min(1.0, 2.0 * float(stdtr(freedom, -farthest.deviations)) * pairs * tests)
        if p_value >= level:
            break
        found.append(replace(farthest, p_value=p_value))
        del left[farthest.rig]
    return found


def _against_others(rig: str, left: Mapping[str, Series], scatter: float) -> Difference:
    others = {name: series for name, series in left.items() if name != rig}
    weights = [float(series.weights.sum()) for series in others.values()]
    value = float(np.average([series.mean for series in others.values()], weights=weights))
    std = float(np.sqrt(scatter * (1.0 / left[rig].weights.sum() + 1.0 / sum(weights))))
    return Difference(rig, tuple(others), left[rig].mean, value, std)
