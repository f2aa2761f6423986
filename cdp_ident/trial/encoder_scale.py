# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether readings are a factor times the angles: the counts per turn are not what they are taken for.

Gravity's torque goes with the sine of an angle, and so shows how large the angle is. Where edges of an encoder's
signals are counted once or four times, or a gear is forgotten, forces balance with the readings over this factor only.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from cdp_ident.trial.meaning import Balance, Recorded, balance_of
from cdp_ident.trial.options import TrialOptions

Joints = tuple[str, ...]
"""The joints whose readings have the same factor."""
Misfit = Callable[[Joints, float], float]
"""What is left with the joints' readings over the exponential of a number; infinite where it cannot be computed."""

_TOGETHER: tuple[Joints, ...] = (("inner",), ("outer",), ("inner", "outer"))
TURNS = 0.5 / np.pi
"""The factor of readings in turns."""
_LIKELY = (TURNS, 0.25, 0.5, 2.0, 4.0)
"""Factors by edges that are counted or not, and that of turns."""
_BETWEEN = 0.067
"""Distance of the others' logarithms that are tried first."""
_LOGARITHMS = np.sort([*np.arange(-24, 25) * _BETWEEN, *np.log(_LIKELY[1:])])
_REFINED = 6
"""The best minima among them are refined: of fast motion the misfit has many."""
_NONE = 1e30
_NEAREST = 0.2
"""Least logarithm of a factor that no effect of the rig is like: one within a tenth is an effect itself, and drag or
friction that no balance knows may look like more."""
_BESIDE = 0.1
"""Weight of the residual's spread beside the share that noise does not explain."""
_ENOUGH = 1500
"""Windows: of more, only some are taken, for neighbours overlap."""
_FAR_LESS = 0.1
"""A likely factor is taken where it leaves less than this share of what is left without it, ..."""
_EXPLAINED = 0.003
"""... and no more than this."""
_WITHIN = 3e-4
"""Accuracy of the logarithm."""


def least_misfit(misfit: Misfit) -> tuple[float, Joints, float]:
    """Return the least misfit of all factors, the joints that have this factor, and its logarithm."""
    tried = np.array([[misfit(joints, logarithm) for logarithm in _LOGARITHMS] for joints in _TOGETHER])
    around = np.pad(tried, ((0, 0), (1, 1)), constant_values=np.inf)
    minima = np.argwhere(np.isfinite(tried) & (tried <= around[:, :-2]) & (tried <= around[:, 2:])).tolist()
    minima.sort(key=lambda place: tried[tuple(place)])
    refined = [refine(misfit, _TOGETHER[joints], float(_LOGARITHMS[near])) for joints, near in minima[:_REFINED]]
    return min(refined, key=lambda found: found[0], default=(np.inf, _TOGETHER[0], 0.0))


def refine(misfit: Misfit, joints: Joints, near: float) -> tuple[float, Joints, float]:
    """Return the least misfit near a factor, the joints that have it, and its logarithm."""

    def finite(logarithm: float) -> float:
        return min(misfit(joints, logarithm), _NONE)

    found = minimize_scalar(
        finite, bounds=(near - _BETWEEN, near + _BETWEEN), method="bounded", options={"xatol": _WITHIN}
    )
    return float(found.fun), joints, float(found.x)


def scaled(options: TrialOptions, joints: Joints, logarithm: float) -> TrialOptions:
    """Return the meaning of angles with the joints' readings over another factor."""
    factors = {f"{joint}_scale": float(np.exp(logarithm)) * getattr(options, f"{joint}_scale") for joint in joints}
    return replace(options, **factors)


def best_scale(recorded: Recorded, options: TrialOptions, *, any_factor: bool, from_zero: bool) -> Balance | None:
    """Return the balance under the meaning of the angles with the factor with which forces balance best.

    A likely factor is taken where it leaves next to nothing. None where no factor is possible, or the best one
    is so near to one that something else may act like it.

    Args:
        recorded: the motion of the recorded joints.
        options: what the angles are taken to mean.
        any_factor: whether others than likely factors are tried, too.
        from_zero: whether readings that are right at zero are tried, too (`scale_from`).
    """
    apart = max(1, sum(map(np.count_nonzero, recorded.moving)) // _ENOUGH)
    some = replace(recorded, moving=tuple(mask & (np.arange(len(mask)) % apart == 0) for mask in recorded.moving))

    def least(base: TrialOptions) -> tuple[float, Joints, float]:
        return least_misfit(lambda joints, log: _left(_possible(balance_of(some, scaled(base, joints, log)))))

    bases = [options, replace(options, scale_from="zero")] if from_zero else [options]
    likely = [scaled(base, joints, log) for base in bases for joints in _TOGETHER for log in np.log(_LIKELY)]
    most = min(_FAR_LESS * _left(balance_of(some, options)), _EXPLAINED)
    tried = [other for meaning in likely if _left(other := _possible(balance_of(some, meaning))) <= most and other]
    if best := min(tried, key=lambda other: other.lumped.misfit, default=None):
        return _possible(balance_of(recorded, best.meaning))
    if not any_factor:
        return None
    (_, joints, logarithm), base = min(((least(base), base) for base in bases), key=lambda found: found[0][0])
    return _possible(balance_of(recorded, scaled(base, joints, logarithm))) if abs(logarithm) > _NEAREST else None


def _possible(balance: Balance | None) -> Balance | None:
    """Return a balance that is certain to be a double pendulum's."""
    return balance if balance and balance.lumped.is_mechanism and balance.lumped.has_certain_signs else None


def _left(balance: Balance | None) -> float:
    # The spread decides between factors that leave nothing but noise.
    return np.inf if balance is None else balance.lumped.unexplained + _BESIDE * balance.lumped.spread
