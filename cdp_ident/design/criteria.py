# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What makes a trial good: by how much it shrinks the uncertainty of what is asked for.

D-optimal is the trial with the smallest determinant of the covariance, that is volume of the confidence region;
c-optimal the one with the smallest variance of one unknown (Pukelsheim, Optimal Design of Experiments, 1993, Chapters 2
and 6; Atkinson, Donev and Tobias, Optimum Experimental Designs, with SAS, 2007, Chapters 10 and 11). What is not asked
for is estimated along with it.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.design.knowledge import Knowledge
from cdp_ident.likelihood.reduction import inverse_of

Array = npt.NDArray[np.float64]


def covariance_of(rows: Array) -> Array:
    """Return the covariance (k, k) of all unknowns, given rows (n, k); infinite for one of which they say nothing."""
    _, covariance, undetermined = inverse_of(rows)
    covariance[undetermined, undetermined] = np.inf
    return covariance


@dataclass(frozen=True)
class Criterion:
    """Asks for some of the unknowns: one of them (c-optimal), or several together (D-optimal)."""

    names: tuple[str, ...]

    def standard_deviations(self, knowledge: Knowledge, rows: Array) -> Array:
        """Return the standard deviations (names,), given rows (n, unknowns) whose products are the information."""
        variances = np.diag(covariance_of(rows))[knowledge.places(self.names)]
        return np.asarray(np.sqrt(variances))

    def size(self, knowledge: Knowledge, rows: Array) -> float:
        """Return how uncertain they are together: the root of the determinant's root of as many; one's own std."""
        asked = knowledge.places(self.names)
        part = covariance_of(rows)[np.ix_(asked, asked)]
        if not np.all(np.isfinite(part)):
            return float("inf")
        scale = np.sqrt(np.maximum(np.diag(part), np.finfo(float).tiny))
        sign, logarithm = np.linalg.slogdet(part / np.outer(scale, scale))
        together = float(np.exp(np.mean(np.log(scale))))
        return together * float(np.exp(logarithm / (2 * len(asked)))) if sign > 0 else 0.0
