# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What makes a trial good: by how much it shrinks the uncertainty of what is asked for.

D-optimal is the trial with the smallest determinant of the covariance, that is volume of the confidence region;
c-optimal the one with the smallest variance of one unknown (Pukelsheim, Optimal Design of Experiments, 1993, Chapters 2
and 6; Atkinson, Donev and Tobias, Optimum Experimental Designs, with SAS, 2007, Chapters 10 and 11). What is not asked
for is estimated along with it.
"""

from collections.abc import Sequence
from typing import NamedTuple

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


class Uncertainty(NamedTuple):
    """Of some of the unknowns: of one of them (c-optimal), or of several together (D-optimal)."""

    std: Array
    """(names,) standard deviations."""
    size: float
    """How uncertain they are together: the root of the determinant's root of as many; one's own deviation."""

    @classmethod
    def of(cls, knowledge: Knowledge, names: Sequence[str], rows: Array) -> "Uncertainty":
        """Return that of the unknowns of these names, given rows (n, unknowns) whose products are the information."""
        asked = knowledge.places(names)
        part = covariance_of(rows)[np.ix_(asked, asked)]
        std = np.sqrt(np.diag(part))
        if not np.all(np.isfinite(part)):
            return cls(std, float("inf"))
        scale = np.maximum(std, np.sqrt(np.finfo(float).tiny))
        sign, logarithm = np.linalg.slogdet(part / np.outer(scale, scale))
        together = float(np.exp(np.mean(np.log(scale))))
        return cls(std, together * float(np.exp(logarithm / (2 * len(asked)))) if sign > 0 else 0.0)
