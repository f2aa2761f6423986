# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The base parameters from measured angles alone, without initial values, a box or a simulation.

The balance of forces in weak form (`trial/balance.py`) is linear in the base parameters and the joints' dry friction
once L and g are known, for A23 = m2 l2 L. It is where a fit begins.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.bounded import minimum_within_limits
from cdp_ident.fit.initial_states import OUTLIER
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.parameters import GROUPS, time_unit
from cdp_ident.model.weights import Weight, added_by
from cdp_ident.trial.balance import COLUMNS, WINDOW, Motion, motion_on_grid, windows
from cdp_ident.trial.kinematics import MEDIAN_OF_SIZE
from cdp_ident.trial.scales import PER_UNIT, Scales
from cdp_ident.trial.trial import Trial

_STRIDE = 3
"""Grid points between neighbouring windows: a quarter of a half width."""
_FEWEST = 10 * _STRIDE
"""Windows in which both joints move that are needed at least."""
_STICKS = 0.1
"""A joint sticks in a window where the direction of its friction is uncertain by more than this share."""
_ROUNDS = 3
_MARGIN = 1.02
"""Least ratio of A33 A22 to A23^2: the rods' masses are not points."""


@dataclass(frozen=True)
class Pieces:
    """The motion of some trials, of a pendulum of which some lengths and gravity are known."""

    length: float
    """L [m]."""
    gravity: float
    """g [m/s^2]."""
    motions: tuple[tuple[Motion, tuple[Weight, ...]], ...]
    """Each with the weights on the rods."""

    @classmethod
    def of(cls, trials: Sequence[Trial], length: float, gravity: float) -> "Pieces":
        """Take the motion of the trials' stretches between gaps that are longer than a rig's time unit."""
        motions = list[tuple[Motion, tuple[Weight, ...]]]()
        for trial in trials:
            for part in trial.stretches:
                scales = Scales.at_least(time_unit(length, gravity), part.time)
                if part.duration > 2 * WINDOW / PER_UNIT * scales.unit:
                    motion = motion_on_grid(part.time, part.theta, part.cart, scales, part.torques)
                    motions.append((motion, trial.weights))
        return cls(length, gravity, tuple(motions))

    @property
    def inertia_free(self) -> bool:
        """Whether weights or motors show A22."""
        return any(of.torques is not None for of, _ in self.motions) or len({on for _, on in self.motions}) > 1

    def basis(self, weights: Sequence[Weight], length_free: bool) -> Array:
        """Return the lumped numbers (columns, unknowns) with weights on the rods that each unknown alone stands for.

        The unknowns are the base parameters, dry friction in both joints, m2 l2 over A22 where L is free, and 1 / A22
        where weights or motors show it.
        """
        g, length = self.gravity, self.length
        found = [{"A23": 1.0}, {"A33": 1.0}, {"G1": g}, {"c1": 1.0}, {"c2": 1.0}, {"k1": 1.0}, {"k2": 1.0}]
        if length_free:
            found.append({"G2": g})
        else:
            found[0]["G2"] = g / length
        if self.inertia_free:
            A22, A23, A33, a1, *_ = added_by(weights, length).tolist()
            moments = {"G1": g * a1, "G2": g / length * A23}
            found.append({"A22": A22, "A23": A23, "A33": A33, **moments, "M1": 1.0, "M2": 1.0})
        return np.array([[of_one.get(column, 0.0) for of_one in found] for column in COLUMNS])


@dataclass(frozen=True)
class ForceBalance:
    """What the balance of forces says about a pendulum."""

    groups: Array
    """(5,) the base parameters, in the order of `GROUPS`."""
    dry_friction: Array
    """(2,) torques of dry friction in both joints, over A22 [1/s^2]."""
    inertia: float | None
    """A22 [kg m^2]; None where neither weights nor motors show it."""
    length: float
    """L [m], as known or as found."""
    unexplained: Array
    """(2,) what is left of the sum's and of the outer rod's balance, as a share of gravity's torque in it; infinite
    where there is none of that, of an outer rod without mass."""


def balance_of_forces(pieces: Pieces, length_free: bool = False) -> ForceBalance:
    """Fit the balance of forces with dry friction in both joints; L is found as A23 over m2 l2 where it is free.

    Raises:
        IdentificationError: there is too little motion.
    """
    plain = pieces.basis((), length_free)
    columns: Array = np.zeros((0, 2, plain.shape[1]))
    target, holds = columns[..., 0], columns[..., 0] > 0.0
    for motion, weights in pieces.motions:
        balance = windows(motion, pieces.gravity, _STRIDE)
        # The sum is free of the outer joint's torque, and the outer rod's equation of the inner joint's, which while a
        # joint sticks is as large as it needs to be.
        balance.terms[:, 0] += balance.terms[:, 1]
        columns = np.concatenate([columns, balance.terms @ pieces.basis(weights, length_free)])
        target = np.concatenate([target, -balance.terms[..., COLUMNS.index("A22")]])
        holds = np.concatenate([holds, balance.slack < _STICKS])
    if np.any(holds.sum(axis=0) < _FEWEST):
        joint = JOINTS[int(np.argmin(holds.sum(axis=0)))]
        raise IdentificationError(f"there is too little motion of the {joint} joint for a balance of forces")
    counts = holds.copy()
    for _ in range(_ROUNDS):
        values = _least_squares(columns, target, counts)
        left = columns @ values - target
        spread = np.array([np.median(np.abs(left[counts[:, k], k])) / MEDIAN_OF_SIZE for k in range(2)])
        counts = holds & (np.abs(left) <= OUTLIER * np.maximum(spread, 1e-300))
    values[1] = max(values[1], _MARGIN * values[0] ** 2)
    numbers = dict(zip(COLUMNS, plain @ values, strict=True))
    moments = np.sin(np.concatenate([motion.angles for motion, _ in pieces.motions])) * [numbers["G1"], numbers["G2"]]
    gravity = np.sqrt([np.mean(moments.sum(axis=1) ** 2), np.mean(moments[:, 1] ** 2)])
    groups, dry_friction, others = np.split(values, [len(GROUPS), len(GROUPS) + len(JOINTS)])
    return ForceBalance(
        groups=groups,
        dry_friction=dry_friction,
        inertia=1.0 / others[-1] if pieces.inertia_free and others[-1] > 0.0 else None,
        length=groups[0] / others[0] if length_free and others[0] else pieces.length,
        unexplained=np.divide(spread, gravity, out=np.full(2, np.inf), where=gravity > 0.0),
    )


def _least_squares(columns: Array, target: Array, counts: Mask) -> Array:
    """Return the values that fit rows best: inertias, moments and frictions, none of which is negative.

    The outer rod's rows, whose target is zero, count as errors of its acceleration: else, nothing at all would fit
    best.
    """
    outer, unknowns = 0.1, columns.shape[-1]
    for _ in range(2):
        weights = counts * [1.0, 1.0 / outer]
        rows, right = (columns * weights[..., None]).reshape(-1, unknowns), (target * weights).ravel()
        size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
        normal, moment = (rows / size).T @ (rows / size), (rows / size).T @ right
        values = minimum_within_limits(normal, moment, np.zeros(unknowns), np.full(unknowns, np.inf)) / size
        outer = max(float(values[1]), 1e-3)
    return values
