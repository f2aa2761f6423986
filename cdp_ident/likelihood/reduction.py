# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What whole swings say of a model's values, once states and impulses of unknown torques are eliminated.

It is a triangle (unknowns, unknowns + 1) whose products are the information, and a determinant for the evidence; see
`sweeps`.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.fit.bounded import minimum_within_limits
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.sweeps import Whitened, backwards
from cdp_ident.likelihood.swing import Linearised, Swing

_NOTHING = 1e-100
"""Length of what is nothing."""
_UNOBSERVABLE = 1e-7
"""Directions of scaled unknowns with less than this share of the largest precision are not determined."""
_TAKES_PART = 1e-3
"""An unknown is not determined that has so much of such a direction, whose parts have squares that add up to 1."""


def reduced(
    model: MotionModel,
    known: Array,
    swings: Sequence[Swing],
    linear: Sequence[Linearised],
    states: Sequence[Array],
    noise: Noise,
    own: int | None = None,
    begins: Indices | None = None,
) -> "Reduced":
    """Return what swings say of a model's values, states and impulses being eliminated.

    Args:
        model: gives the motion.
        known: (k, unknowns + 1) rows of what is known beforehand; see `Known.rows`.
        swings: what was measured.
        linear: each of them near states and values.
        states: (nodes, states) of each.
        noise: of encoders and unknown torques.
        own: how many of the unknowns are estimated, the others being candidates; all of them by default.
        begins: (unknowns + 1 - own,) the first candidate with which each, and the readings, have a product that is
            wanted; by default all are.
    """
    unknowns = known.shape[1] - 1
    own = unknowns if own is None else own
    rows, logarithm, parts = [known], 0.0, list[Part]()
    others = np.zeros((unknowns + 1 - own,) * 2)
    begins = np.zeros(len(others), dtype=np.int64) if begins is None else begins
    for swing, of, nodes_states in zip(swings, linear, states, strict=True):
        whitened = noise.whitened(swing, of, noise.tails_of(len(parts)))
        nodes, n, d = whitened.transitions.shape
        estimated = n + int(np.sum(of.columns < own))
        triangles, impulses = np.empty((nodes, estimated, d + 1)), np.empty((nodes, 2, d + 3))
        left = np.empty((1, d + 1 - estimated, d + 1 - estimated))
        columns = np.append(of.columns, unknowns)
        candidates = columns[estimated - n :] - own
        of_swing = np.searchsorted(candidates, begins[candidates])
        logarithm += backwards(whitened, impulses, triangles, left, of_swing, memory_for_rows(swing, estimated, d))
        first, of_start = _with_start(triangles[0], swing, model, nodes_states[0], noise, n)
        logarithm += of_start
        of_values = np.zeros((len(first) - n, unknowns + 1))
        of_values[:, columns] = first[n:, n:]
        rows.append(of_values)
        others[np.ix_(candidates, candidates)] += left[0]
        parts.append(Part(first, impulses, whitened))
    # What the values take from the noise is accounted for as well (Patterson and Thompson, Biometrika 58, 1971).
    whole = triangle_of(np.concatenate(rows))
    last = whole[own:, own:]
    return Reduced(whole[:own], others + last.T @ last, logarithm + _logarithm_of_square(whole[:own, :own]), parts)


def memory_for_rows(swing: Swing, estimated: int, directions: int) -> Array:
    """Return the memory that `backwards` needs."""
    return np.empty((directions + 3, estimated + 2 + 2 * int(np.diff(swing.samples_at).max())))


def _with_start(
    triangle: Array, swing: Swing, model: MotionModel, start: Array, noise: Noise, n: int
) -> tuple[Array, float]:
    """Return a first node's triangle (k, d + 1) with what is known of its state, and the logarithm of a determinant."""
    deviations = np.append(swing.start_deviations(model), noise.new[: n - len(start)])
    begins = np.zeros((n, triangle.shape[1]))
    begins[:, :n] = np.diag(1.0 / deviations)
    begins[: len(start), -1] = start / deviations[: len(start)]
    first = triangle_of(np.concatenate([triangle, begins]))
    known = 2.0 * float(np.sum(np.log(deviations[np.isfinite(deviations)])))
    return first, known + _logarithm_of_square(first[:n, :n])


class Part(NamedTuple):
    """What a swing says."""

    first: Array
    """(d + 1, d + 1) of the state at its first node and of its unknowns, a triangle."""
    impulses: Array
    """(nodes, 2, d + 3) rows that give the impulses; see `backwards`."""
    swing: Whitened

    def first_node(self, change: Array, covariance: Array, columns: Indices) -> tuple[Array, Array]:
        """Return the most likely deviation (d,) at the first node, and its covariance, given those of the values."""
        n = self.first.shape[1] - 1 - len(columns)
        inverse = np.linalg.pinv(self.first[:n, :n])
        by_values = -inverse @ self.first[:n, n:-1]
        given = np.concatenate([by_values, np.eye(len(columns))])
        spread = given @ covariance[np.ix_(columns, columns)] @ given.T
        spread[:n, :n] += inverse @ inverse.T
        return np.concatenate([by_values @ change - inverse @ self.first[:n, -1], change]), spread


class Reduced(NamedTuple):
    """What all swings say of the values."""

    of_values: Array
    """(own, unknowns + 1) a triangle."""
    others: Array
    """(k, k) products of what is left of candidates and readings once these are estimated."""
    logarithm: float
    """Of a determinant."""
    parts: list[Part]

    def squares(self, change: Array) -> float:
        """Return the sum of squares that is left where the values (own,) are changed."""
        left = self.of_values[:, :-1] @ change + self.of_values[:, -1]
        return float(left @ left + self.others[-1, -1])

    def times(self, factor: float) -> "Reduced":
        """Return what so many times as much motion of the same kind says."""
        of_values, own = np.sqrt(factor) * self.of_values, self._of_own
        others, logarithm = factor * self.others, factor * (self.logarithm - own)
        return Reduced(of_values, others, logarithm + _logarithm_of_square(of_values[:, :-1]), [])

    def with_more(self, more: "Reduced") -> "Reduced":
        """Return what both say, where this is what `more` took as known beforehand."""
        return more._replace(others=self.others + more.others, logarithm=self.logarithm - self._of_own + more.logarithm)

    @property
    def _of_own(self) -> float:
        """What the values add to the logarithm."""
        return _logarithm_of_square(self.of_values[:, :-1])


def triangle_of(rows: Array) -> Array:
    """Return the triangle (k, k) whose products are those of rows (n, k)."""
    return np.asarray(np.linalg.qr(rows, mode="r"))


def _scaled(triangle: Array) -> tuple[Array, Array]:
    """Return a triangle (k, k) with columns of length one, and their lengths (k,)."""
    lengths = np.maximum(np.linalg.norm(triangle, axis=0), _NOTHING)
    return triangle / lengths, lengths


def _logarithm_of_square(triangle: Array) -> float:
    """Return the logarithm of the square of a triangle's determinant, but for what it does not determine."""
    scaled, lengths = _scaled(triangle)
    sizes = np.linalg.svd(scaled, compute_uv=False)
    determined = lengths[lengths > _NOTHING], sizes[sizes > _UNOBSERVABLE * sizes[0]]
    return 2.0 * sum(float(np.sum(np.log(of))) for of in determined)


def inverse_of(rows: Array) -> tuple[Array, Array, Array]:
    """Return the pseudo-inverse (k, n) of rows (n, k), the covariance (k, k) they give, and what is undetermined."""
    scaled, lengths = _scaled(rows)
    left, sizes, right = np.linalg.svd(scaled)
    rank = int(np.sum(sizes > _UNOBSERVABLE * sizes.max(initial=0.0)))
    inverse = right[:rank].T / sizes[:rank] / lengths[:, None]
    return inverse @ left[:, :rank].T, inverse @ inverse.T, np.any(np.abs(right[rank:]) > _TAKES_PART, axis=0)


def information_of(covariance: Array) -> Array:
    """Return the pseudo-inverse (k, k) of a covariance, in whatever units its numbers are."""
    deviations = np.sqrt(np.diag(covariance))
    units = np.where(deviations > 0.0, deviations, 1.0)
    return np.asarray(np.linalg.pinv(covariance / np.outer(units, units), hermitian=True) / np.outer(units, units))


def most_likely_change(model: MotionModel, values: Array, triangle: Array) -> tuple[Array, Array, Array]:
    """Return the change of the values (unknowns,) within their limits, their covariance, and what is undetermined."""
    of_values, target = triangle[:, :-1], triangle[:, -1]
    inverse, covariance, undetermined = inverse_of(of_values)
    change = -inverse @ target
    lower = np.maximum(np.minimum(model.limits[0] - values, 0.0), -model.reach)
    upper = np.minimum(np.maximum(model.limits[1] - values, 0.0), model.reach)
    if np.any((change < lower) | (change > upper)):
        change = minimum_within_limits(of_values.T @ of_values, -of_values.T @ target, lower, upper)
    return change, covariance, undetermined
