"""From derivatives of a motion by what it is carried on with to those by the unknowns of a fit."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import compiled

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


@dataclass(frozen=True)
class ChainRule:
    """What each direction of a motion's derivatives contributes to those by the unknowns."""

    unknown_of: Indices
    """(directions,) the unknown that a direction is the derivative by, -1 for none."""
    direction: Indices
    """(k,) directions on which a further unknown acts, too, …"""
    unknown: Indices
    """(k,) … that unknown, …"""
    factor: Array
    """(k,) … and the direction's derivative by it."""

    def by_unknowns(self, derivatives: Array, count: int) -> Array:
        """Return derivatives (n, 2, count) by the unknowns from those (n, 2, directions) by the first directions."""
        result = np.empty((*derivatives.shape[:2], count))
        given = derivatives.shape[2]
        whole = slice(None if given == len(self.unknown_of) else 0)
        _by_unknowns(
            derivatives, self.unknown_of[:given], self.direction[whole], self.unknown[whole], self.factor[whole], result
        )
        return result


@compiled
def _by_unknowns(derivatives, unknown_of, direction, unknown, factor, result):
    for j in range(len(derivatives)):
        for r in range(2):
            for k in range(result.shape[2]):
                result[j, r, k] = 0.0
            for d in range(len(unknown_of)):
                if unknown_of[d] >= 0:
                    result[j, r, unknown_of[d]] = derivatives[j, r, d]
            for e in range(len(direction)):
                result[j, r, unknown[e]] += factor[e] * derivatives[j, r, direction[e]]
