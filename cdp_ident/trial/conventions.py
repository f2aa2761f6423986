"""Whether the angles mean what they are taken to mean, by the physics of the motion itself.

Of the meanings that the outer angle can have, only the right one lets the balance of forces hold (`balance`): the
others leave a tenth of the acceleration or more unexplained where the right one leaves some thousandths. Half a turn
of a zero changes no residual but the signs: gravity would push up, or the rods' coupling be negative.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import TrialError
from cdp_ident.trial.balance import Lumped, Motion, fit_lumped, windows
from cdp_ident.trial.joints import model_angles
from cdp_ident.trial.options import OuterAngle, TrialOptions, Zero

Mask = npt.NDArray[np.bool_]

_FEWEST_WINDOWS = 100
"""Windows that show motion, below which nothing can be said: one second's worth."""
_MUCH_BETTER = 0.33
"""Another meaning must leave less than this share of the residual to speak against the one given."""
_GOOD = 0.02
"""Unexplained share of the acceleration that is no evidence against a meaning."""
_CLEAR = 0.01
"""A coupling, and one rod's gravity as a share of the other's, that is more than an error of the fit."""
_NO_PENDULUM = 0.25
"""Unexplained share above which the motion is not that of a free double pendulum."""
_EVIDENT = 0.05
"""Unexplained share up to which wrong signs are evidence of a wrong zero, not of a hand."""


@dataclass(frozen=True)
class Balance:
    """The balance of forces of some motions, under one meaning of their angles."""

    windows: tuple[tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]], ...]
    """Of each motion: coefficients and target, as `balance.windows` returns them."""
    lumped: Lumped


def in_model_angles(motion: Motion, options: TrialOptions) -> Motion:
    """Return a motion of the recorded joints as one of theta1 and theta2."""
    still = model_angles(np.zeros((1, 2)), options)
    return replace(
        motion, angles=model_angles(motion.angles, options), rates=model_angles(motion.rates, options) - still
    )


def check_conventions(
    motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions
) -> tuple[Balance | None, list[str]]:
    """Compare what the options say about the angles with the balance of forces.

    Args:
        motions: of the recorded joints.
        moving: of each motion, the windows (as many as `balance.windows` returns) that show one.
        options: what the angles are taken to mean.

    Returns:
        The balance under that meaning, or None where there is too little motion for one, and warnings.

    Raises:
        TrialError: the data contradict the options and `options.conventions` is "refuse".
    """
    if sum(np.count_nonzero(mask) for mask in moving) < _FEWEST_WINDOWS:
        return None, ["there is too little motion to check the joints' conventions or to tell a hand from free motion"]
    given = _balance(motions, moving, options)
    meanings = [
        replace(options, outer_angle=outer_angle, outer_sign=outer_sign)
        for outer_angle, outer_sign in itertools.product(get_args(OuterAngle), (1, -1))
    ]
    fits = [(meaning, _balance(motions, moving, meaning).lumped) for meaning in meanings if meaning != options]
    possible = [(meaning, fit) for meaning, fit in fits if fit.is_mechanism or fit.is_mechanism_upside_down]
    other, fit = min(possible, key=lambda pair: pair[1].unexplained, default=(options, given.lumped))
    turned = [(meaning, fit) for meaning, fit in fits if fit.is_mechanism_with_outer_rod_turned]
    best, its_fit = min((*turned, (other, fit)), key=lambda pair: pair[1].unexplained)
    if given.lumped.unexplained > _GOOD and its_fit.unexplained < _MUCH_BETTER * given.lumped.unexplained:
        contradiction = _better(options, best, given.lumped, its_fit)
    elif given.lumped.unexplained > (_NO_PENDULUM if given.lumped.is_mechanism else _EVIDENT):
        contradiction = (
            f"most of the motion is not that of a free double pendulum: {given.lumped.unexplained:.1%} of the inner "
            "rod's acceleration is explained neither by gravity, coupling and friction nor by another meaning of the "
            "angles; if a hand moves the rods for long, take the part without it by start and stop"
        )
    elif given.lumped.is_mechanism:
        ambiguous = other != options and fit.unexplained < given.lumped.unexplained / _MUCH_BETTER
        return given, [_cannot_tell(options, other, given.lumped, fit)] if ambiguous else []
    else:
        contradiction = _wrong_signs(options, given.lumped)
    if options.conventions == "refuse":
        raise TrialError(f"{contradiction}; conventions: warn takes the data all the same")
    return given, [contradiction]


def _balance(motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions) -> Balance:
    balances = tuple(windows(in_model_angles(motion, options)) for motion in motions)
    coefficients, target = (np.concatenate(part) for part in zip(*balances, strict=True))
    return Balance(balances, fit_lumped(coefficients, target, np.concatenate(moving)))


def _changes(options: TrialOptions, other: TrialOptions, fit: Lumped) -> str:
    """Return which options would have to be set to what, for another meaning of the outer angle."""
    if fit.is_mechanism_upside_down:
        other = replace(other, zero=_opposite(other.zero))
    names = ("outer_angle", "outer_sign", "zero")
    changes = [f"{name}: {getattr(other, name)}" for name in names if getattr(other, name) != getattr(options, name)]
    if fit.is_mechanism_with_outer_rod_turned:
        changes.append("the outer joint's zero half a turn on")
    return " and ".join(changes)


def _opposite(zero: Zero) -> Zero:
    return "hanging" if zero == "upright" else "upright"


def _better(options: TrialOptions, other: TrialOptions, given: Lumped, fit: Lumped) -> str:
    return (
        f"the data contradict outer_angle: {options.outer_angle} with outer_sign: {options.outer_sign}, which leaves "
        f"{given.unexplained:.1%} of the inner rod's acceleration unexplained: {_changes(options, other, fit)} leaves "
        f"{fit.unexplained:.1%}; set that"
    )


def _cannot_tell(options: TrialOptions, other: TrialOptions, given: Lumped, fit: Lumped) -> str:
    return (
        f"the data cannot tell outer_angle: {options.outer_angle} ({given.unexplained:.1%} unexplained) from "
        f"{_changes(options, other, fit)} ({fit.unexplained:.1%}): make sure that it is right"
    )


def _wrong_signs(options: TrialOptions, given: Lumped) -> str:
    """Say what half a turn of one zero would put right."""
    A, *_, G1, G2 = given.values
    evidence = f"gravity terms of the rods {G1:+.1f} and {G2:+.1f} 1/s^2, coupling {A:+.2f}; all must be positive"
    if given.is_mechanism_upside_down:
        return f"the data contradict zero: {options.zero} ({evidence}): set zero: {_opposite(options.zero)}"
    is_clear = A < -_CLEAR and min(abs(G1), abs(G2)) > _CLEAR * max(abs(G1), abs(G2))
    if is_clear and (G1 < 0) != (G2 < 0):
        joint = "inner" if G1 < 0 else "outer"
        return f"the zero of the {joint} joint is half a turn from where it is taken to be ({evidence}): set it anew"
    return f"no double pendulum moves like this ({evidence}): check the joints' names, signs and units"
