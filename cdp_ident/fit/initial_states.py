"""The windows' initial states, eliminated from a fit: the part of the residuals that they explain, and the rest.

Every window has an initial state of its own, which is fitted with everything else. A window in which a joint stands
still does not determine all of it, and in chaotic motion its components are strongly correlated; directions that are
not determined are left unchanged.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_CUT_OFF = 1e-13
"""Eigenvalue of a scaled matrix, as a share of the largest, below which a direction counts as undetermined."""
_ROUNDING = 1e-30
"""Diagonal element, as a share of the largest, that is rounding error."""
_TOGETHER = 64
"""Windows whose matrices are decomposed at a time."""


def inverse_factor(matrix: Array) -> Array:
    """Return F (…, n, n) such that F F^T is the inverse of positive semi-definite matrices (…, n, n).

    Where there is none it is the pseudo-inverse of the matrix scaled to a diagonal of ones; what is not finite in a
    matrix counts as zero.
    """
    diagonal = np.einsum("...kk->...k", matrix)
    finite = np.all(np.isfinite(matrix), axis=-1)
    largest = np.max(np.where(finite, diagonal, 0.0), axis=-1, keepdims=True, initial=0.0)
    shown = finite & (diagonal > _ROUNDING * largest)
    scale = np.where(shown, 1.0 / np.sqrt(np.where(shown, diagonal, 1.0)), 0.0)
    both = shown[..., :, None] & shown[..., None, :]
    scaled = np.where(both, matrix, 0.0) * scale[..., :, None] * scale[..., None, :]
    values, vectors = np.linalg.eigh(scaled)
    kept = values > _CUT_OFF * values[..., -1:]
    root = np.where(kept, 1.0 / np.sqrt(np.where(kept, values, 1.0)), 0.0)
    return np.asarray(scale[..., :, None] * vectors * root[..., None, :])


@dataclass(frozen=True)
class InitialState:
    """The part of a window's rows (two angles of each sample, one below the other) that its initial state explains.

    It is described by coordinates whose sensitivities are orthonormal.
    """

    transform: Array
    """(4, 4) change of the initial state by each coordinate; zero for those that the window does not determine."""
    basis: Array
    """(rows, 4) change of the rows by each coordinate: orthonormal columns, or zero."""

    @classmethod
    def of(cls, by_state: Array, known: bool = False) -> "InitialState":
        """Make it of the rows' derivatives (rows, 4) by the initial state; one that is `known` changes nothing."""
        return next(cls.of_each([(by_state, known)]))

    @classmethod
    def of_each(cls, windows: Iterable[tuple[Array, bool]]) -> "Iterator[InitialState]":
        """Make those of windows, each with its rows' derivatives and whether its initial state is known.

        Some are decomposed at a time: their matrices are small.
        """
        left = iter(windows)
        while together := list(islice(left, _TOGETHER)):
            factors = inverse_factor(np.array([by_state.T @ by_state for by_state, _ in together]))
            bases = [by_state @ factor for (by_state, _), factor in zip(together, factors, strict=True)]
            # The squares have lost digits, which a second pass brings back (Yamamoto et al., CholeskyQR2, ETNA 44,
            # 2015).
            again = inverse_factor(np.array([basis.T @ basis for basis in bases]))
            for (_, known), factor, basis, second in zip(together, factors, bases, again, strict=True):
                yield (
                    cls(np.zeros_like(factor), np.zeros_like(basis)) if known else cls(factor @ second, basis @ second)
                )

    def change_for(self, rows: Array) -> Array:
        """Return the change (4, …) of the initial state that comes nearest to rows (rows, …)."""
        return np.asarray(self.transform @ (self.basis.T @ rows))

    def eliminated_from(self, rows: Array) -> Array:
        """Return the part of rows (rows, …) that no initial state explains (their projection)."""
        return np.asarray(rows - self.basis @ (self.basis.T @ rows))

    @property
    def covariance(self) -> Array:
        """(4, 4) covariance of the initial state where that of the rows is one."""
        return np.asarray(self.transform @ self.transform.T)
