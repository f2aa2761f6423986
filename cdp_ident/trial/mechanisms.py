# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What else two columns look like, and where a double pendulum is driven: equations of motion one by one.

Whatever drives its pivot, a pendulum obeys one equation, linear in what is not known. With its angle t, w = t', and the
speed v of a cart, or of an arm about an upright axis::

    w' + c w + k sign(w) + d |w| w + b [(cos(t) v)' + sin(t) w v] + e sin(2 t) v^2 = G sin(t)

without e on a cart, and without b beside something else; with cosines beside the sines, as the angle's zero is not
known. Of a double pendulum whose inner joint is driven, the outer rod's equation holds, and where the outer joint is
driven, the sum of both rods'. All are taken in weak form, as in `balance`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from scipy.special import erf

from cdp_ident.arrays import Array
from cdp_ident.model.effects.effect import JOINTS, Joint
from cdp_ident.trial.balance import COLUMNS, Motion, Windows, over_windows, window_weights
from cdp_ident.trial.lumped import COUPLED
from cdp_ident.trial.meaning import EVIDENT, MUCH_BETTER, SOME, Balance
from cdp_ident.trial.recorded_motion import Recorded

HOLDS = 0.01
"""Share of its acceleration up to which a single equation holds."""
_NOISE = 0.01
"""Share of the mean square of a pendulum's acceleration up to which noise in the other terms tells nothing else."""
_NOTHING = 0.002
"""So much of the acceleration is left by what a motion's grid neglects."""
_MOST, _OUTLIER = 0.9, 13.0
"""It holds in this share of the windows at least: without those of squares so many times the median."""
_ROUNDS, _SINGULAR = 3, 1e-10
_FEWEST = 60
"""Windows, below which an equation may hold by chance."""
_BENT = 0.05
"""Across the arc, what goes along a circle varies by this share of its radius at least."""
_SPEED = 0.99
"""Correlation from which a column is a speed, though the other's is smoothed."""
_PIVOTS = {
    "": 4,
    "beside something else, which has nothing to do with it": 6,
    "on a cart (or an arm that turns little), whose position is the other column": 8,
    "on an arm, whose angle about an upright axis is the other column (Furuta's)": 10,
}
"""What the other column has to do with a pendulum, and of how many of its `_terms`; without gravity, it is none."""
_DRIVEN: dict[Joint, tuple[slice, tuple[str, ...]]] = {
    "inner": (slice(1, 2), ("A33", "A23", "c2", "k2", "G2", "E2")),
    "outer": (slice(2), ("A22", "A23", "A33", "c1", "k1", "G1", "G2", "E1", "E2")),
}
"""The rods whose equations hold together whatever drives a joint, and their terms."""

_WITHOUT = 6
"""Terms of a pendulum with a pivot at rest."""
_SIGMAS = 3.0
_FOLLOWS = 0.95
"""Correlation of the joints' speeds from which one column is said to follow the other."""
_TWICE = 0.05
"""Share of the inner angle that the outer one differs from it by at most, as one measured and simulated does."""


@dataclass(frozen=True)
class Pendulum:
    """One of two columns as the angle of a pendulum."""

    words: str
    """What it looks like."""
    unexplained: float
    """Share of its acceleration (rms) that its equation leaves, but for noise."""
    terms: int
    """Of its equation."""

    @property
    def is_moved(self) -> bool:
        """Whether the other column tells how its pivot moves."""
        return self.terms > _WITHOUT


def one_pendulum(recorded: Recorded, balances: Sequence[Balance], given: Balance | None) -> Pendulum | None:
    """Return the one pendulum that the motion looks like; None where two rods explain it as well, or nothing does.

    `balances` are those under the meanings that the outer angle can have. The outer rod's alone counts, too: it is a
    pendulum on a pivot that moves.
    """
    # Rods with strong effects leave more than noise in many windows, but not so much.
    if given and given.lumped.may_be_rods and (given.lumped.beyond <= SOME or given.lumped.unexplained <= EVIDENT):
        return None
    found = pendulum(recorded)
    rods = [balance for balance in balances if balance.lumped.may_be_rods]
    left = [unexplained_beside(of.trusted, "inner") for of in rods]
    left += [of.lumped.unexplained for of in rods if of.lumped.beyond <= SOME]
    return found if found and found.unexplained < MUCH_BETTER * min(left, default=np.inf) else None


def other_mechanism(recorded: Recorded, balances: Sequence[Balance], given: Balance, other: Pendulum | None) -> str:
    """Return what two columns look like that are no two rods', whatever they mean; empty where they may be.

    `balances` are those under the meanings that the outer angle can have, and `other` is one pendulum that moves so.
    """
    fits = [balance.lumped for balance in balances]
    couplings = [(fit.values[0], np.sqrt(fit.covariance[0, 0])) for fit in fits]
    apart = [f"coupling {A:+.3f} ± {std:.1g}" for A, std in couplings if abs(A) + _SIGMAS * std < COUPLED]
    inner, outer = np.concatenate([motion.angles - motion.angles.mean(axis=0) for motion in recorded.motions]).T
    is_twice = np.std(outer - inner) < _TWICE * np.std(inner)
    if any(fit.may_be_rods for fit in fits):
        apart, is_twice = [], False
    if not (apart or is_twice or other):
        return ""
    correlation = float(np.corrcoef(np.concatenate([motion.rates for motion in recorded.motions]).T)[0, 1])
    words = other.words if other else "one column beside something else, or joints that motors drive"
    if (is_twice or abs(correlation) > _FOLLOWS) and not (other and other.is_moved):
        twice = "one angle twice, measured and simulated or filtered"
        words = f"{twice}: the outer column follows the inner one (correlation {correlation:.2f})"
    evidence = f"the two columns have nothing to do with each other as rods do ({apart[0]})" if apart else ""
    return f"{evidence}: {words}" if evidence else f"it looks like {words}"


def driven(given: Balance) -> str:
    """Say in which joint what is unexplained acts; empty where it may be either, or anything else."""
    left = {joint: unexplained_beside(given.trusted, joint) for joint in JOINTS}
    joint = min(JOINTS, key=lambda joint: left[joint])
    most = min(HOLDS, *(MUCH_BETTER * of for of in (given.lumped.unexplained, max(left.values()))))
    if left[joint] >= most:
        return ""
    return f"it acts in the {joint} joint (a motor, a hand, a spring?), beside which {left[joint]:.1%} is left"


def pendulum(recorded: Recorded) -> Pendulum | None:
    """Return the pendulum that one of two recorded columns looks like; None where neither does."""
    points, speeds = (np.concatenate([getattr(of, name) for of in recorded.motions]) for name in ("angles", "rates"))
    if other := _on_circle(points) or _of_speed(points, speeds):
        return other
    found = [one for place in range(2) if (one := pendulum_of(recorded, place))]
    # What both leave next to nothing of is the simpler one: a free cart goes with its pendulum.
    return min(found, key=lambda one: (max(one.unexplained, _NOTHING), one.terms), default=None)


def unexplained_beside(balance: Windows, joint: Joint) -> float:
    """Return the share of a rod's acceleration that is unexplained (rms) if something unknown drives a joint.

    It is that of the outer rod, or of the inner one where the outer joint is driven; infinite where none holds.
    """
    rods, names = _DRIVEN[joint]
    columns = [COLUMNS.index(name) for name in names]
    noise = np.mean(balance.noise[:, rods], axis=0)
    return _left(
        np.sum(balance.terms[:, rods][..., columns], axis=1), lambda of: float(np.sum(noise)) * (1.0 + of[0] ** 2)
    )


def _on_circle(points: Array) -> Pendulum | None:
    """Return that columns (n, 2) are the coordinates of a point that goes along a circle; None where they are not."""
    centred = points - points.mean(axis=0)
    (*half, square), *_ = np.linalg.lstsq(
        np.column_stack([2.0 * centred, np.ones(len(centred))]), np.sum(centred**2, axis=1), rcond=None
    )
    radius = float(np.sqrt(max(square + np.dot(half, half), 0.0)))
    off = float(np.std(np.linalg.norm(centred - half, axis=1)))
    is_bent = np.linalg.svd(centred, compute_uv=False)[-1] > _BENT * radius * np.sqrt(len(centred))
    words = f"x and y of a point on a circle of {radius:.3g}, to {off / radius:.1%}: one pendulum in coordinates"
    return Pendulum(words, off / radius, max(_PIVOTS.values())) if is_bent and off < HOLDS * radius else None


def _of_speed(points: Array, speeds: Array) -> Pendulum | None:
    """Return that one of two columns (n, 2) goes with the speed of the other, in any unit; None where neither does."""
    with np.errstate(invalid="ignore"):  # a column that stands still goes with nothing
        alike = [abs(float(np.corrcoef(points[:, 1 - place], speeds[:, place])[0, 1])) for place in range(2)]
    place = int(np.argmax(alike))
    words = f"one joint's angle (the {JOINTS[place]} column) and its speed (correlation {alike[place]:.3f})"
    return Pendulum(words, np.sqrt(1.0 - alike[place] ** 2), max(_PIVOTS.values())) if alike[place] > _SPEED else None


def pendulum_of(recorded: Recorded, place: int) -> Pendulum | None:
    """Return the pendulum of which one of two recorded columns looks like the angle; None where it does not."""
    parts = (_terms(part, place)[moving] for part, moving in recorded.moving_parts)
    rows = np.concatenate([np.empty((0, max(_PIVOTS.values()))), *parts])
    of_angle, of_pivot = recorded.motions[0].gain * recorded.motions[0].angle_noise[[place, 1 - place]] ** 2
    left = {
        pivot: _left(rows[:, :terms], lambda of: float(of_angle + of_pivot * np.sum(of[5:7] ** 2)))
        for pivot, terms in _PIVOTS.items()
    }
    # A simpler one will do where it leaves next to nothing, or not far more.
    pivot = reduce(lambda one, other: other if left[other] < MUCH_BETTER * left[one] > _NOTHING else one, _PIVOTS)
    if not pivot or left[pivot] > HOLDS:
        return None
    words = f"one pendulum (the {JOINTS[place]} column) {pivot}: that leaves {left[pivot]:.1%} of its acceleration"
    return Pendulum(words, left[pivot], _PIVOTS[pivot])


def _terms(motion: Motion, place: int) -> Array:
    """Return the terms (k, 10) of a pendulum's equation in windows, with one column as its angle."""
    value, slope = window_weights(motion.scales.spacing)
    (t, _), (w, v) = (np.roll(of, -place, axis=1).T for of in (motion.angles, motion.rates))
    s, c = np.sin(t), np.cos(t)
    direction = erf(w / (np.sqrt(2.0) * motion.scales.slow))
    torques = [
        w,
        direction,
        np.abs(w) * w,
        -s,
        -c,
        s * w * v,
        -c * w * v,
        np.sin(2.0 * t) * v**2,
        np.cos(2.0 * t) * v**2,
    ]
    terms = np.column_stack([over_windows(of, value) for of in (np.zeros_like(w), *torques)])
    for k, momentum in ((0, w), (6, c * v), (7, s * v)):
        terms[:, k] += over_windows(momentum, slope)
    return terms


def _left(rows: Array, noise: Callable[[Array], float]) -> float:
    """Return the share of the first of some terms (n, k) that the others leave, by least squares without outliers.

    `noise` is the variance of the noise in it, by the others' factors. The share is infinite where there are too many
    outliers, too few rows, or where noise may be a good part of what is explained.
    """
    kept = np.ones(len(rows), dtype=bool)
    for _ in range(_ROUNDS if len(rows) >= _FEWEST else 0):
        scale = np.linalg.norm(rows[kept], axis=0) + np.finfo(float).tiny
        factors = np.linalg.lstsq(rows[kept, 1:] / scale[1:], -rows[kept, 0], rcond=_SINGULAR)[0] / scale[1:]
        squares = (rows @ [1.0, *factors]) ** 2
        kept = squares <= _OUTLIER * np.median(squares)
    whole = float(np.sum(rows[kept, 0] ** 2))
    if len(rows) < _FEWEST or np.mean(kept) < _MOST or not whole:
        return np.inf
    by_noise = np.count_nonzero(kept) * noise(factors)
    if by_noise > _NOISE * whole:
        return np.inf  # where noise may be as much as that, little is left of anything
    return float(np.sqrt(max(float(np.sum(squares[kept])) - by_noise, 0.0) / whole))
