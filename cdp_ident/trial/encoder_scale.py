"""Whether readings are a factor times the angles: the counts per turn are not what they are taken for.

Gravity's torque goes with the sine of an angle, and so shows how large the angle is. Where edges of an encoder's
signals are counted once or four times, or a gear is forgotten, forces balance with the readings over this factor only.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from cdp_ident.arrays import Mask
from cdp_ident.trial.lumped import Lumped
from cdp_ident.trial.meaning import balance_of
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.weak_form import Motion

Joints = tuple[str, ...]
"""The joints whose readings have the same factor."""
Misfit = Callable[[Joints, float], float]
"""What is left with the joints' readings over the exponential of a number; infinite where it cannot be computed."""

_TOGETHER: tuple[Joints, ...] = (("inner",), ("outer",), ("inner", "outer"))
_LIKELY = (0.25, 0.5, 2.0, 4.0)
"""Factors by edges that are counted or not."""
_BETWEEN = 0.067
"""Distance of the others' logarithms that are tried first."""
_LOGARITHMS = np.sort([*np.arange(-24, 25) * _BETWEEN, *np.log(_LIKELY)])
_REFINED = 6
"""The best minima among them are refined: of fast motion the misfit has many."""
_NONE = 1e30
_NEAREST = 0.03
"""Least logarithm of a factor that is no effect of the rig, such as an encoder disc off its centre."""
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


def best_scale(
    motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions, *, any_factor: bool, from_zero: bool
) -> tuple[TrialOptions, Lumped] | None:
    """Return the meaning of the angles with the factor with which forces balance best.

    A likely factor is taken where it leaves next to nothing. None where no factor is possible, or the best one
    is so near to one that something else may act like it.

    Args:
        motions: of the recorded joints.
        moving: of each motion, the windows that show one.
        options: what the angles are taken to mean.
        any_factor: whether others than likely factors are tried, too.
        from_zero: whether readings that are right at zero are tried, too (`scale_from`).
    """
    apart = max(1, sum(np.count_nonzero(mask) for mask in moving) // _ENOUGH)
    some = [mask & (np.arange(len(mask)) % apart == 0) for mask in moving]

    def balanced(meaning: TrialOptions, moving: Sequence[Mask] = some) -> Lumped | None:
        found = balance_of(motions, moving, meaning)
        return found.lumped if found and found.lumped.is_mechanism and found.lumped.has_certain_signs else None

    def least(base: TrialOptions) -> tuple[float, Joints, float]:
        return least_misfit(lambda joints, logarithm: _left(balanced(scaled(base, joints, logarithm))))

    given = balance_of(motions, some, options)
    most = min(_FAR_LESS * _left(given.lumped if given else None), _EXPLAINED)
    bases = [options, replace(options, scale_from="zero")] if from_zero else [options]
    likely = [scaled(base, joints, log) for base in bases for joints in _TOGETHER for log in np.log(_LIKELY)]
    left, best = min(((_left(balanced(other)), other) for other in likely), key=lambda found: found[0])
    if left > most:
        if not any_factor:
            return None
        (_, joints, logarithm), base = min(((least(base), base) for base in bases), key=lambda found: found[0][0])
        if abs(logarithm) <= _NEAREST:
            return None
        best = scaled(base, joints, logarithm)
    found = balanced(best, moving)
    return (best, found) if found else None


def _left(lumped: Lumped | None) -> float:
    # The spread decides between factors that leave nothing but noise.
    return np.inf if lumped is None else lumped.unexplained + _BESIDE * lumped.spread
