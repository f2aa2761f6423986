"""What makes a trial good: by how much it shrinks the uncertainty of what is asked for.

D-optimal is the trial with the smallest determinant of the covariance, that is volume of the confidence region;
c-optimal the one with the smallest variance of one unknown (Pukelsheim, Optimal Design of Experiments, 1993, Chapters 2
and 6; Atkinson, Donev and Tobias, Optimum Experimental Designs, with SAS, 2007, Chapters 10 and 11). What is not asked
for is estimated along with it.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.design.information import scaled_inverse
from cdp_ident.design.knowledge import Knowledge

Array = npt.NDArray[np.float64]

_UNOBSERVABLE = 1e-14
"""Directions with less than this share of the largest information are not seen."""


def covariance_of(information: Array) -> Array:
    """Return the covariance (k, k) of all unknowns; infinite for one of which the information says nothing."""
    seen = np.diag(information) > 0.0
    inverse, left_out = scaled_inverse(information[np.ix_(seen, seen)], _UNOBSERVABLE)
    result = np.diag(np.full(len(information), np.inf))
    result[np.ix_(seen, seen)] = inverse
    unseen = np.flatnonzero(seen)[np.any(np.abs(left_out) > 1e-3, axis=1)]
    result[unseen, unseen] = np.inf
    return result


@dataclass(frozen=True)
class Criterion:
    """Asks for some of the unknowns: one of them (c-optimal), or several together (D-optimal)."""

    names: tuple[str, ...]

    def standard_deviations(self, knowledge: Knowledge, information: Array) -> Array:
        """Return the standard deviations (names,) under an information (unknowns, unknowns)."""
        variances = np.diag(covariance_of(information))[knowledge.places(self.names)]
        return np.asarray(np.sqrt(variances))

    def size(self, knowledge: Knowledge, information: Array) -> float:
        """Return how uncertain they are together: the root of the determinant's root of as many; one's own std."""
        asked = knowledge.places(self.names)
        part = covariance_of(information)[np.ix_(asked, asked)]
        if not np.all(np.isfinite(part)):
            return float("inf")
        sign, logarithm = np.linalg.slogdet(part / np.outer(*2 * [_scale(part)]))
        scale = float(np.exp(np.mean(np.log(_scale(part)))))
        return scale * float(np.exp(logarithm / (2 * len(asked)))) if sign > 0 else 0.0


def _scale(part: Array) -> Array:
    return np.sqrt(np.maximum(np.diag(part), np.finfo(float).tiny))
