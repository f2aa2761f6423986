# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The lumped numbers with which the balance of forces holds in most of a motion."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv

from cdp_ident.arrays import Array, Indices
from cdp_ident.trial.balance import COLUMNS, Windows, residual, torques

_TRIMMED_ROUNDS = 12
_STRETCH, _SHORTEST_STRETCH = 100, 50
"""Windows of a stretch from which the fit may begin: five units of the motion's time scale, or down to half of that
where there are fewer than four such stretches. A hand may lead strongly damped rods up for as long as they swing: one
of the stretches is to be free of it."""
_FEWEST_STRETCHES = 4
_MOST_STRETCHES = 24
_AGREEMENT = 0.05
"""Unexplained torque, as a share of gravity's, with which a window agrees with a fit."""
_WORTH = 0.9
"""With a geared rotor or errors of zeros, the squared residual must fall below this share."""
_BEYOND = 9.2
"""Squared error, over its variance, that one in a hundred normal errors in two dimensions exceeds."""
_OUTLIER = _BEYOND / (2 * np.log(2))
"""The same over the median one."""
_LARGEST_OFFSET = 0.3
"""Error of a zero [rad] up to which a first-order expansion is accurate enough."""
_INDEPENDENT = 5
"""Neighbouring windows overlap: so many count as one independent window."""
_SIGMAS = 3.0
_NEGLECTED = 1e-3
"""Share of the acceleration that the grid and the smoothing leave without any noise."""
_SINGULAR = 1e-12
_REGULAR = 1e-9
"""Determinant of a correlation matrix above which it is solved directly: over e it is below the least eigenvalue."""
COUPLED = 0.02
"""Least coupling A23 / A22 of two rods: those that are known have 0.1 and more."""
_VISCOUS = (0, 1, 2, 3, 4, 5)
_FRICTION = (6, 7)
_ROTOR, _OFFSETS, _MOTORS = (8,), (9, 10, 11), (12, 13)
FREE_JOINTS, DRIVEN_JOINTS = (*_VISCOUS, *_FRICTION), (*_VISCOUS, *_FRICTION, *_MOTORS)
"""Places of the lumped numbers without what is there in few rigs, and with motors in the joints."""


Turned = Literal["", "both", "inner", "outer"]


@dataclass(frozen=True)
class Lumped:
    """Lumped numbers fitted to windows of motion."""

    values: Array
    """(14,) in the order of `balance.COLUMNS` after A22, relative to it; A, B, D, E12 [1], c1, c2 [1/s], M1, M2 [1/s^2]
    over the unit of the torques, the others [1/s^2]."""
    unexplained: float
    """Share of the inner rod's acceleration (rms) in the windows fitted to, and of what motors in the joints would give
    it, that is not explained, by noise neither."""
    misfit: float
    """Mean of log(1 + what is left over what noise leaves, squared) in all windows, for comparing meanings of the
    angles: each has its noise, and a hand weighs the same under all."""
    beyond: float
    """Share of all windows in which far more is left than noise leaves: a hand's, or of a meaning with which the
    balance holds in some of the motion only."""
    spread: float
    """Median of the unexplained `torques` of those windows."""
    covariance: Array
    """(6, 6) of the first six values."""

    @property
    def length_over_gravity(self) -> tuple[float, float]:
        """L / g [s^2], as A = m2 L l2 and G2 = m2 l2 g over the same A22, and its deviation to first order."""
        places = [0, 5]
        A, G2 = self.values[places]
        if not G2:
            return np.inf, np.inf
        slope = np.array([1.0, -A / G2]) / G2
        return float(A / G2), float(np.sqrt(max(0.0, slope @ self.covariance[np.ix_(places, places)] @ slope)))

    @property
    def has_certain_signs(self) -> bool:
        """Whether the signs of A, G1 and G2, which tell what is upside down, are more than an error of the fit."""
        places = [0, 4, 5]
        return bool(np.all(np.abs(self.values[places]) > _SIGMAS * np.sqrt(np.diag(self.covariance)[places])))

    @property
    def turned(self) -> Turned | None:
        """Which rods' zeros are half a turn off, for there to be a double pendulum with these numbers; None for none.

        Its inertias are positive, and gravity pulls down: half a turn of a rod changes the signs of its terms.
        """
        A, B, _, _, G1, G2, *_ = self.values
        signs: dict[tuple[bool, bool, bool], Turned] = {
            (True, True, True): "", (True, False, False): "both",
            (False, True, False): "outer", (False, False, True): "inner",
        }  # fmt: skip
        return signs.get((A > 0, G1 > 0, G2 > 0)) if A**2 < B and A and G1 and G2 else None

    @property
    def is_mechanism(self) -> bool:
        """Whether there is a double pendulum with these numbers."""
        return self.turned == ""

    @property
    def is_certain(self) -> bool:
        """Whether there is, and no error of the fit makes it one."""
        return self.is_mechanism and self.has_certain_signs

    @property
    def may_be_rods(self) -> bool:
        """Whether the numbers are certain to be a double pendulum's, zeros half a turn off included."""
        return self.turned is not None and self.has_certain_signs and abs(self.values[0]) > COUPLED


def fit_lumped(balance: Windows, is_driven: bool = False) -> Lumped:
    """Fit the lumped numbers to the windows of which most agree, whatever the others say.

    Of the windows, which show motion, the half that fits worst is left out (least trimmed squares with concentration
    steps: Rousseeuw and Van Driessen, 2006). The fit begins with that of the short stretch with which most windows of
    the recording agree, so that a hand cannot draw it to its own motion. At last all windows that are no outliers are
    fitted to. Dry friction that comes out negative is none; a geared rotor is there, and zeros are off, where that
    explains much that nothing else does. `is_driven` says that the torques of motors are an input.
    """
    motors = _MOTORS if is_driven else ()
    at_least = max(1, min(_FEWEST_STRETCHES, len(balance) // _SHORTEST_STRETCH))
    count = max(at_least, min(_MOST_STRETCHES, len(balance) // _STRETCH))
    stretches = [_Scaled.of(_products(part)) for part in np.array_split(balance.terms, count)]
    fits = [_least_squares(stretch, (*_VISCOUS, *motors)) for stretch in stretches]
    values = max(fits, key=lambda fit: np.count_nonzero(torques(balance, fit) < _AGREEMENT))
    keep = (len(balance) + 1) // 2
    chosen: Indices = np.empty(0, dtype=np.int64)
    for _ in range(_TRIMMED_ROUNDS):
        best = np.asarray(np.sort(np.argsort(_squares(balance, values), kind="stable")[:keep]))
        if np.array_equal(best, chosen):
            break
        chosen = best
        values = _physical(_products(balance.terms[chosen]), keep, motors)
    squares = _squares(balance, values)
    fitted = balance[squares <= _OUTLIER * np.median(squares)]
    products = _products(fitted.terms)
    values = _physical(products, len(fitted), motors)
    left = float(np.sum(_squares(fitted, values)))
    A, B = np.clip(values[:2], -1, 1) ** 2
    noise = float(fitted.noise.sum(axis=0) @ [1.0 + A, A + B])
    # Motors hold rods up, too, that hardly accelerate.
    whole = products[0, 0] + sum(values[k] ** 2 * products[1 + k, 1 + k] for k in motors)
    unexplained = np.sqrt(max(left - noise, 0.0) / whole) if whole > 0 else np.inf
    variance = balance.noise @ [1.0 + A, A + B] + _NEGLECTED**2 * products[0, 0] / len(fitted) + np.finfo(float).tiny
    over = _squares(balance, values) / variance
    misfit, beyond = float(np.mean(np.log1p(over))), float(np.mean(over > _BEYOND))
    spread = float(np.median(torques(fitted, values)))
    covariance = _covariance(products, left / max(1, 2 * len(fitted)), motors)
    return Lumped(values, float(unexplained), misfit, beyond, spread, covariance)


def explained(balance: Windows, columns: Sequence[int]) -> tuple[Array, float]:
    """Return the numbers (14,) in some columns that fit windows best, and the share of the squares that they leave."""
    products = _products(balance.terms)
    values = _least_squares(_Scaled.of(products), columns)
    return values, _left(products, values) / max(products[0, 0], np.finfo(float).tiny)


def gravity_directions(balance: Windows) -> Array:
    """Return how far gravity's direction is from where each rod's angle takes it to be (2,) [rad], as angles count.

    It is any from -pi to pi: gravity's terms and the coupling are fitted with sine and cosine to windows that show
    motion, twice, the second time without outliers.
    """
    values, _ = explained(balance, (*DRIVEN_JOINTS, *_OFFSETS))
    squares = _squares(balance, values)
    values, _ = explained(balance[squares <= _OUTLIER * np.median(squares)], (*DRIVEN_JOINTS, *_OFFSETS))
    return np.arctan2(values[[10, 11]], values[[4, 5]])


def _products(terms: Array) -> Array:
    """Return the sums of products (15, 15) of windows' terms (k, 2, 15): what least squares need to know of them."""
    rows = terms.reshape(-1, len(COLUMNS))
    return np.asarray(rows.T @ rows)


def _left(products: Array, values: Array) -> float:
    """Return the squared residual that values (14,) leave."""
    with_target = np.array([1.0, *values])
    return float(with_target @ products @ with_target)


def _squares(balance: Windows, values: Array) -> Array:
    left = residual(balance, values)
    return np.asarray(np.einsum("kr,kr->k", left, left))


def _covariance(products: Array, variance: float, motors: tuple[int, ...]) -> Array:
    """Return the covariance of the first six numbers (6, 6) with residuals of a `variance` [(rad/s^2)^2]."""
    correlation, _, scale = _Scaled.of(products).of_columns((*FREE_JOINTS, *motors))
    eigenvalues, directions = np.linalg.eigh(correlation)
    # What the motion does not show at all is as uncertain as can be said.
    inverse = directions / np.maximum(eigenvalues, _SINGULAR) @ directions.T
    covariance = inverse / np.outer(scale, scale) * variance * _INDEPENDENT
    return np.asarray(covariance[: len(_VISCOUS), : len(_VISCOUS)])


class _Scaled(NamedTuple):
    """Sums of products of terms that are scaled: a joint that hardly moves does not decide about others by rounding."""

    products: Array
    """(15, 15), of which all diagonal elements but the target's are 1, or 0."""
    scale: Array
    """(15,) which the terms are over."""

    @classmethod
    def of(cls, products: Array) -> "_Scaled":
        scale = np.sqrt(products.diagonal())
        scale[scale == 0] = 1.0
        scale[0] = 1.0
        return cls(products / (scale[:, None] * scale), scale)

    def of_columns(self, columns: Sequence[int]) -> tuple[Array, Array, Array]:
        """Return matrix (k, k) and right side (k,) of the numbers in some columns, times their scales (k,)."""
        places = 1 + np.asarray(columns)
        matrix = self.products.take(places, 0).take(places, 1)
        return matrix, -self.products[0].take(places), self.scale.take(places)


def _physical(products: Array, count: int, motors: tuple[int, ...]) -> Array:
    """Fit with dry friction where it is positive, a geared rotor and zeros that are off where that is worth it.

    What is worth it follows from Schwarz's criterion, with those of the `count` windows that tell something of their
    own as its data.
    """
    independent = max(2.0, 2 * count / _INDEPENDENT)
    for_one = min(_WORTH, independent ** (-1 / independent))
    best: Array = np.zeros(len(COLUMNS) - 1)
    least, scaled = np.inf, _Scaled.of(products)
    for added in ((), _ROTOR, _OFFSETS, (*_ROTOR, *_OFFSETS)):
        values = _with_friction(scaled, (*_VISCOUS, *motors, *added))
        score = _left(products, values) / for_one ** len(added)
        # Errors of zeros are fitted as three numbers, though two would do; larger ones are none to first order.
        if score < least and np.all(np.abs(values[10:12]) <= _LARGEST_OFFSET * np.abs(values[4:6])):
            best, least = values, score
    return best


def _with_friction(scaled: _Scaled, columns: Sequence[int]) -> Array:
    """Fit the numbers in some columns, and friction that is positive."""
    friction = list(_FRICTION)
    while True:
        values = _least_squares(scaled, [*columns, *friction])
        if all(values[column] >= 0 for column in friction):
            return values
        friction.remove(min(friction, key=lambda column: values[column]))


def _least_squares(scaled: _Scaled, columns: Sequence[int]) -> Array:
    """Return the numbers (14,) that fit best, of which all but those in the given columns are zero.

    Where the equations are singular, they are the smallest ones.
    """
    matrix, right, scale = scaled.of_columns(columns)
    factor, solution, failed = dposv(matrix, right)
    if failed or factor.diagonal().prod() ** 2 <= _REGULAR:
        solution = np.linalg.lstsq(matrix, right, rcond=_SINGULAR)[0]
    values = np.zeros(len(COLUMNS) - 1)
    values.put(columns, solution / scale)
    return values
