# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which rig differs from the others."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.special import stdtr

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Difference:
    """A rig that differs from others."""

    rig: str
    others: tuple[str, ...]
    """Those that remain when rigs that differ more are left out."""
    value: float
    """Its mean."""
    others_value: float
    """The others' mean."""
    std: float
    """Of the difference of the two."""
    p_value: float = 1.0

    @property
    def deviations(self) -> float:
        """The difference, in standard deviations."""
        return abs(self.value - self.others_value) / self.std if self.std > 0.0 else 0.0


def differing(series: Mapping[str, tuple[Array, Array]], level: float, tests: int = 1) -> list[Difference]:
    """Return the rigs that differ from the others, the one that differs most first.

    The rig whose weighted mean is farthest from that of all others, in standard deviations, is taken out while it is
    farther than chance would have it, and the rest are compared again. The standard deviations are known up to one
    factor, which is estimated from the scatter within the rigs; differences have Student's distribution then, by
    Bonferroni's inequality for the farthest of several. Of two rigs that remain, the second differs from the first.

    Args:
        series: values (n,) and their standard deviations (n,) by rig; values of one rig belong together.
        level: a difference whose `p_value` is not below this is none.
        tests: how many quantities are compared together.
    """
    left = dict(series)
    weights = {rig: np.asarray(std, dtype=float) ** -2.0 for rig, (_, std) in series.items()}
    means = {rig: float(np.average(values, weights=weights[rig])) for rig, (values, _) in series.items()}
    freedom = sum(len(values) - 1 for values, _ in series.values())
    if freedom < 1:
        return []
    squares = sum(float(np.sum(weights[rig] * (values - means[rig]) ** 2)) for rig, (values, _) in series.items())
    scatter = squares / freedom
    found = []
    while len(left) > 1:
        compared = [_against_others(rig, left, means, weights, scatter) for rig in left]
        farthest = max(reversed(compared), key=lambda difference: difference.deviations)
        pairs = len(left) if len(left) > 2 else 1
        p_value = min(1.0, 2.0 * float(stdtr(freedom, -farthest.deviations)) * pairs * tests)
        if p_value >= level:
            break
        found.append(replace(farthest, p_value=p_value))
        del left[farthest.rig]
    return found


def _against_others(
    rig: str,
    left: Mapping[str, tuple[Array, Array]],
    means: Mapping[str, float],
    weights: Mapping[str, Array],
    scatter: float,
) -> Difference:
    others = tuple(other for other in left if other != rig)
    together = [float(weights[other].sum()) for other in others]
    value = float(np.average([means[other] for other in others], weights=together))
    std = float(np.sqrt(scatter * (1.0 / weights[rig].sum() + 1.0 / sum(together))))
    return Difference(rig, others, means[rig], value, std)
