"""Derivatives of windows, kept without the columns that are zero.

Of many unknowns a window shows few: the zeros of its own trial's encoders, and the part of a curve that it passes. An
hour of motion with all of them would take gigabytes.
"""

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_MANY = 32
"""With fewer columns all are kept."""
TOGETHER = 512
"""Windows whose matrices are there at the same time."""


class Sensitivities(Sequence[Array]):
    """(n, 2, columns) derivatives of the angles of each window."""

    def __init__(self, windows: int, columns: int):
        self._columns = columns
        self._kept: list[tuple[Array, Indices | None]] = [(np.empty(0), None)] * windows

    def __len__(self) -> int:
        return len(self._kept)

    @overload
    def __getitem__(self, index: int) -> Array: ...
    @overload
    def __getitem__(self, index: slice) -> list[Array]: ...
    def __getitem__(self, index: int | slice) -> Array | list[Array]:
        if isinstance(index, slice):
            return [self[place] for place in range(*index.indices(len(self)))]
        kept, columns = self._kept[index]
        if columns is None:
            return kept
        whole = np.zeros((*kept.shape[:-1], self._columns))
        whole[..., columns] = kept
        return whole

    def put(self, index: int, whole: Array) -> None:
        """Keep those of a window."""
        if self._columns < _MANY:
            self._kept[index] = whole, None
            return
        columns = np.flatnonzero(np.any(whole, axis=(0, 1)))
        self._kept[index] = whole[..., columns], columns


class Normals:
    """(columns, columns) symmetric matrix of each window."""

    def __init__(self, windows: int, columns: int):
        self._windows, self._columns = windows, columns
        self._whole = np.empty((windows if columns < _MANY else 0, columns, columns))
        self._kept: list[tuple[Array, Indices]] = [(np.empty(0), np.empty(0, dtype=np.int64))] * windows

    def put(self, index: int, whole: Array) -> None:
        """Keep that of a window."""
        if self._columns < _MANY:
            self._whole[index] = whole
            return
        columns = np.flatnonzero(np.any(whole, axis=0))
        self._kept[index] = whole[np.ix_(columns, columns)], columns

    def parts(self) -> Iterator[tuple[slice, Array]]:
        """Yield windows, and copies (windows, columns, columns) of their matrices."""
        for first in range(0, self._windows, TOGETHER):
            part = slice(first, min(first + TOGETHER, self._windows))
            yield part, self._matrices(part)

    def times(self, vectors: Array) -> Array:
        """Return the products (windows, columns) with vectors (windows, columns)."""
        products = [np.einsum("wkl,wl->wk", matrices, vectors[part]) for part, matrices in self.parts()]
        return np.concatenate(products)

    @property
    def diagonals(self) -> Array:
        """(windows, columns) diagonals of the matrices."""
        return np.concatenate([np.einsum("wkk->wk", matrices) for _, matrices in self.parts()])

    def _matrices(self, part: slice) -> Array:
        if self._columns < _MANY:
            return self._whole[part].copy()
        whole = np.zeros((part.stop - part.start, self._columns, self._columns))
        for matrix, (kept, columns) in zip(whole, self._kept[part], strict=True):
            matrix[np.ix_(columns, columns)] = kept
        return whole
