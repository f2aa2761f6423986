# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether readings are a factor times the angles: the counts per turn are not what they are taken for.

Gravity's torque goes with the sine of an angle, and so shows how large the angle is. Where edges of an encoder's
signals are counted once or four times, or a gear is forgotten, forces balance with the readings over this factor only.
"""

import itertools
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from cdp_ident.trial.meaning import Balance, Recorded, balance_of
from cdp_ident.trial.options import TrialOptions

Joints = tuple[str, ...]
"""The joints whose readings have the same factor."""

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


def _scaled(options: TrialOptions, joints: Joints, logarithm: float) -> TrialOptions:
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

    def tried(base: TrialOptions, joints: Joints, logarithm: float) -> Balance | None:
        return _possible(balance_of(some, _scaled(base, joints, logarithm)))

    bases = [options, replace(options, scale_from="zero")] if from_zero else [options]
    choices = list(itertools.product(bases, _TOGETHER))
    most = min(_FAR_LESS * _left(balance_of(some, options)), _EXPLAINED)
    likely = [tried(*choice, logarithm) for choice in choices for logarithm in np.log(_LIKELY)]
    explaining = [other for other in likely if other and _left(other) <= most]
    if explaining:
        return _possible(balance_of(recorded, min(explaining, key=lambda other: other.lumped.misfit).meaning))
    if not any_factor:
        return None
    left = np.array([[_left(tried(*choice, logarithm)) for logarithm in _LOGARITHMS] for choice in choices])
    around = np.pad(left, ((0, 0), (1, 1)), constant_values=np.inf)
    minima = np.argwhere(np.isfinite(left) & (left <= around[:, :-2]) & (left <= around[:, 2:])).tolist()
    minima.sort(key=lambda place: left[tuple(place)])

    def refined(choice: int, near: float) -> tuple[float, int, float]:
        found = minimize_scalar(
            lambda logarithm: min(_left(tried(*choices[choice], logarithm)), _NONE),
            bounds=(near - _BETWEEN, near + _BETWEEN),
            method="bounded",
            options={"xatol": _WITHIN},
        )
        return float(found.fun), choice, float(found.x)

    found = [refined(choice, _LOGARITHMS[near]) for choice, near in minima[: _REFINED * len(bases)]]
    _, choice, logarithm = min(found, default=(np.inf, 0, 0.0))
    return _possible(balance_of(recorded, _scaled(*choices[choice], logarithm))) if abs(logarithm) > _NEAREST else None


def _possible(balance: Balance | None) -> Balance | None:
    """Return a balance that is certain to be a double pendulum's."""
    return balance if balance and balance.lumped.is_certain else None


def _left(balance: Balance | None) -> float:
    # The spread decides between factors that leave nothing but noise.
    return np.inf if balance is None else balance.lumped.unexplained + _BESIDE * balance.lumped.spread
