# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The base parameters and strong effects from measured angles alone, without initial values, a box or a simulation.

The balance of forces in weak form (`trial/weak_form.py`) is linear in the base parameters once L and g are known, for
A23 = m2 l2 L. It is where a fit begins, and it shows effects that are so strong that the paper's model fits too badly
for its residual to show them.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.bounded import minimum_within_limits
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import JOINTS, Effect, Law
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA, time_unit
from cdp_ident.model.weights import Weight, added_by
from cdp_ident.trial.balance import motion_on_grid
from cdp_ident.trial.differences import MEDIAN_OF_SIZE
from cdp_ident.trial.scales import PER_UNIT, Scales
from cdp_ident.trial.trial import Trial
from cdp_ident.trial.weak_form import COLUMNS, WINDOW, Motion, integrated

_COLUMNS_OF: Mapping[Law, Mapping[str, str]] = {
    Law(friction="torque"): {"torque": "k"},
    Law(torque="torque - stiffness*angle"): {"stiffness": "s", "torque": "t"},
    Law(torque="torque"): {"torque": "t"},
    Law(torques=("-coupling*alpha2", "-coupling*alpha1")): {"coupling": "D"},
}
"""The laws that are looked for, and for each parameter the lumped number that it is."""
_LOOKED_FOR = tuple(effect for effect in CATALOGUE if effect.law in _COLUMNS_OF)
DRY = tuple(effect for effect in _LOOKED_FOR if effect.dry)
"""The dry friction that is looked for, which may be in several joints together."""
NOT_DRY = tuple(effect for effect in _LOOKED_FOR if not effect.dry)
"""What else is looked for, one at a time."""
MOMENT = "m2_l2_over_A22"
"""Name of the unknown by which L is sought: it is A23 over this."""

STRIDE = 3
"""Grid points between neighbouring windows: a quarter of a half width."""
_FEWEST = 10 * STRIDE
"""Windows in which both joints move that are needed at least."""
_STICKS = 0.1
"""A joint sticks in a window where the direction of its friction is uncertain by more than this share."""
_OUTLIER = 6.0
"""Rows beyond so many robust standard deviations do not count."""
_ROUNDS = 3
_NO_TORQUE = 1e-9
"""Gravity's torque over A22 that is none [rad/s^2]."""
_MARGIN = 1.02
"""Least ratio of A33 A22 to A23^2: the rods' masses are not points."""
LEAVES = 0.7
"""A coupling or a spring leaves at most this share of what a joint's balance does not explain without it: a smaller
part may be that of several weak effects, which the selection tells apart."""
CLEARLY_BETTER = 20.0
"""A balance with one effect more is clearly the better one where it lowers the information criterion by so much."""


@dataclass(frozen=True)
class Pieces:
    """The motion of some trials, of a pendulum of which some lengths and gravity are known."""

    length: float
    """L [m]."""
    gravity: float
    """g [m/s^2]."""
    motions: tuple[Motion, ...]
    weights: tuple[tuple[Weight, ...], ...]
    """On the rods in each motion."""

    @classmethod
    def of(cls, trials: Sequence[Trial], length: float, gravity: float) -> "Pieces":
        """Take the motion of the trials' stretches between gaps that are longer than a rig's time unit."""
        unit = time_unit(length, gravity)
        motions, weights = list[Motion](), list[tuple[Weight, ...]]()
        for trial in trials:
            for stretch in trial.stretches:
                scales = Scales.at_least(unit, stretch.time)
                if stretch.duration > 2 * WINDOW / PER_UNIT * scales.unit:
                    motions.append(motion_on_grid(stretch.time, stretch.theta, stretch.cart, scales, stretch.torques))
                    weights.append(trial.weights)
        return cls(length, gravity, tuple(motions), tuple(weights))

    def with_joints_turned(self, inner: float, outer: float) -> "Pieces":
        """Return the motion as if the joints had turned so many times as far from where the rods hang."""
        change = np.array([[inner, 0.0], [inner - outer, outer]])
        turned = (
            replace(
                motion,
                angles=np.pi + (motion.angles - np.pi) @ change.T,
                rates=motion.rates @ change.T,
                angle_noise=np.sqrt(motion.angle_noise**2 @ (change**2).T),
            )
            for motion in self.motions
        )
        return replace(self, motions=tuple(turned))

    @property
    def motors(self) -> bool:
        """Whether torques of motors are known, which show A22."""
        return any(motion.torques is not None for motion in self.motions)

    @property
    def inertia_free(self) -> bool:
        """Whether weights or motors show A22."""
        return self.motors or len(set(self.weights)) > 1


@dataclass(frozen=True)
class ForceBalance:
    """What the balance of forces says about a pendulum."""

    names: tuple[str, ...]
    """Base parameters, on request m2 l2, 1 / A22, then parameters of effects."""
    values: Array
    """(n,) their values, over A22."""
    covariance: Array
    """(n, n) of these."""
    found: tuple[tuple[Effect, Array], ...]
    """The effects that were found, and the values (k,) of their parameters."""
    criterion: float
    """Bayesian information criterion (Schwarz, 1978)."""
    unexplained: Array
    """(2,) what is left of the sum's and of the outer rod's balance, as a share of gravity's torque in it; infinite
    where there is none of that, of an outer rod without mass."""
    noise_share: Array
    """(2,) what the angles' noise alone leaves, as the same share."""
    rows: Array
    """(2,) independent windows in which either balance counts."""
    length: float
    """L [m], as known or as found."""

    @property
    def groups(self) -> Array:
        """(5,) the base parameters, in the order of `GROUPS`."""
        return self.values[: len(GROUPS)]

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects that were found."""
        return tuple(effect for effect, _ in self.found)

    @property
    def inertia(self) -> float | None:
        """A22 [kg m^2]; None where neither weights nor motors show it."""
        if INVERSE_INERTIA.symbol not in self.names:
            return None
        inverse = float(self.values[self.names.index(INVERSE_INERTIA.symbol)])
        return 1.0 / inverse if inverse > 0.0 else None

    @property
    def beyond_noise(self) -> Array:
        """(2,) the unexplained shares without those of noise."""
        return np.sqrt(np.maximum(self.unexplained**2 - self.noise_share**2, 0.0))

    @property
    def misfit(self) -> float:
        """Minus twice the logarithm of the likelihood, but for a constant, of what is left as a share of gravity's."""
        return float(2.0 * self.rows @ np.log(np.maximum(self.unexplained, np.finfo(float).tiny)))


def balance_of_forces(pieces: Pieces, effects: Sequence[Effect] = (), length_free: bool = False) -> ForceBalance:
    """Fit the balance of forces with given effects of those that are looked for.

    Raises:
        IdentificationError: there is too little motion.
    """
    names, basis = _unknowns(pieces, effects, length_free)
    needed = [COLUMNS.index("A22"), *np.flatnonzero(basis(()).any(axis=1)).tolist()]
    columns: Array = np.zeros((0, 2, len(names)))
    target, holds = columns[..., 0], columns[..., 0] > 0.0
    for motion, weights in zip(pieces.motions, pieces.weights, strict=True):
        lumped, uncertain = integrated(motion, pieces.gravity, [COLUMNS[place] for place in needed], STRIDE)
        # The sum is free of the outer joint's torque, and the outer rod's equation of the inner joint's, which while a
        # joint sticks is as large as it needs to be.
        lumped[:, 0] += lumped[:, 1]
        columns = np.concatenate([columns, lumped @ basis(weights)[needed]])
        target, holds = np.concatenate([target, -lumped[..., 0]]), np.concatenate([holds, uncertain < _STICKS])
    if np.any(holds.sum(axis=0) < _FEWEST):
        joint = JOINTS[int(np.argmin(holds.sum(axis=0)))]
        raise IdentificationError(f"there is too little motion of the {joint} joint for a balance of forces")
    bounds = _bounds(names, effects)
    counts = holds.copy()
    for _ in range(_ROUNDS):
        values, normal = _least_squares(columns, target, counts, bounds)
        left = columns @ values - target
        spread = np.array([np.median(np.abs(left[counts[:, k], k])) / MEDIAN_OF_SIZE for k in range(2)])
        counts = holds & (np.abs(left) <= _OUTLIER * np.maximum(spread, 1e-300))
    values[1] = max(values[1], _MARGIN * values[0] ** 2)
    numbers = dict(zip(COLUMNS, basis(()) @ values, strict=True))
    angles = np.concatenate([motion.angles for motion in pieces.motions])
    moments = np.sin(angles) * [numbers["G1"], numbers["G2"]]
    gravity = np.sqrt([np.mean(moments.sum(axis=1) ** 2), np.mean(moments[:, 1] ** 2)])
    coupling = values[0] * np.cos(angles[:, 0] - angles[:, 1])
    by_accelerations = [[1.0 + coupling, coupling + values[1]], [coupling, np.full(len(coupling), values[1])]]
    of_noise = np.mean(np.square(by_accelerations), axis=-1) @ np.mean([m.noise for m in pieces.motions], axis=0)
    is_heavy = gravity > _NO_TORQUE
    rows = counts.sum(axis=0) / (WINDOW // (2 * STRIDE))
    misfit = rows @ (np.log(np.maximum(spread, 1e-150) ** 2) - [0.0, np.log(max(values[1] ** 2, 1e-300))])
    first = len(names) - sum(len(effect.parameters) for effect in effects)
    ends = first + np.cumsum([len(effect.parameters) for effect in effects], dtype=int)
    return ForceBalance(
        names=names,
        values=values,
        covariance=np.asarray(np.linalg.pinv(normal, hermitian=True) * (WINDOW // (2 * STRIDE)), dtype=float),
        found=tuple((e, values[end - len(e.parameters) : end]) for e, end in zip(effects, ends, strict=True)),
        criterion=float(misfit + len(names) * np.log(max(rows.sum(), 2.0))),
        unexplained=np.divide(spread, gravity, out=np.full(2, np.inf), where=is_heavy),
        noise_share=np.divide(np.sqrt(of_noise), gravity, out=np.zeros(2), where=is_heavy),
        rows=rows,
        length=values[0] / values[names.index(MOMENT)]
        if length_free and values[names.index(MOMENT)]
        else pieces.length,
    )


def _unknowns(
    pieces: Pieces, effects: Sequence[Effect], length_free: bool
) -> tuple[tuple[str, ...], Callable[[Sequence[Weight]], Array]]:
    """Return the names of what is sought, and a function from weights on the rods to the lumped numbers that they are.

    These are (columns, names).
    """
    g, length = pieces.gravity, pieces.length
    of_effects = [(effect, parameter.name) for effect in effects for parameter in effect.parameters]
    names = (
        *(group.symbol for group in GROUPS),
        *((MOMENT,) if length_free else ()),
        *((INVERSE_INERTIA.symbol,) if pieces.inertia_free else ()),
        *(f"{effect.key}.{name}" for effect, name in of_effects),
    )

    def basis(weights: Sequence[Weight]) -> Array:
        found: list[dict[str, float]] = [{"A23": 1.0}, {"A33": 1.0}, {"G1": g}, {"c1": 1.0}, {"c2": 1.0}]
        if length_free:
            found.append({"G2": g})
        else:
            found[0]["G2"] = g / length
        if pieces.inertia_free:
            A22, A23, A33, a1, *_ = added_by(weights, length).tolist()
            moments = {"G1": g * a1, "G2": g / length * A23}
            found.append({"A22": A22, "A23": A23, "A33": A33, **moments, "M1": 1.0, "M2": 1.0})
        for effect, name in of_effects:
            column = _COLUMNS_OF[effect.law][name]
            found.append({column if column in COLUMNS else f"{column}{1 + JOINTS.index(effect.joint)}": 1.0})
        return np.array([[of_one.get(column, 0.0) for of_one in found] for column in COLUMNS])

    return names, basis


def _bounds(names: Sequence[str], effects: Sequence[Effect]) -> tuple[Array, Array]:
    """Return the lowest and the highest value of each unknown: inertias, moments and frictions are not negative."""
    parameters = [parameter for effect in effects for parameter in effect.parameters]
    plain = len(names) - len(parameters)
    lower = np.array([0.0] * plain + [parameter.lower for parameter in parameters])
    return lower, np.array([np.inf] * plain + [parameter.upper for parameter in parameters])


def _least_squares(columns: Array, target: Array, counts: Mask, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the values that fit rows best, and the normal matrix over the variance of what is left.

    The outer rod's rows, whose target is zero, count as errors of its acceleration: else, nothing at all would fit
    best.
    """
    outer = 0.1
    for _ in range(2):
        weights = counts * [1.0, 1.0 / outer]
        rows, right = (columns * weights[..., None]).reshape(-1, columns.shape[-1]), (target * weights).ravel()
        size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
        normal, moment = (rows / size).T @ (rows / size), (rows / size).T @ right
        values = minimum_within_limits(normal, moment, bounds[0] * size, bounds[1] * size) / size
        outer = max(float(values[1]), 1e-3)
    variance = np.mean((rows @ values - right) ** 2) + np.finfo(float).tiny
    return values, normal * np.outer(size, size) / variance


def balances_of(pieces: Pieces) -> tuple[ForceBalance, ...]:
    """Return the balances of forces, the one with the best choice of effects first.

    Where that has any, the one with dry friction in both joints follows, as friction in one may hide that in the other.

    Raises:
        IdentificationError: there is too little motion.
    """
    subsets = [subset for count in range(len(DRY) + 1) for subset in itertools.combinations(DRY, count)]

    def best(besides: tuple[Effect, ...]) -> ForceBalance:
        found = [balance_of_forces(pieces, (*besides, *dry)) for dry in subsets]
        return min(found, key=lambda one: one.criterion + CLEARLY_BETTER * len(one.effects))

    plain = preferred = best(())
    besides: tuple[Effect, ...] = ()
    for effect in NOT_DRY:
        other = best((effect,))
        if np.all(other.beyond_noise > LEAVES * plain.beyond_noise):
            continue
        if other.criterion < min(preferred.criterion, plain.criterion - CLEARLY_BETTER):
            preferred, besides = other, (effect,)
    if not preferred.effects or preferred.effects == (*besides, *DRY):
        return (preferred,)
    return preferred, balance_of_forces(pieces, (*besides, *DRY))
