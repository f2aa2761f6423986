"""Check of the angles' conventions by the physics of the motion itself.

Of the meanings that the outer angle can have, only the right one satisfies the balance of forces (`balance`): the
others leave a tenth of the acceleration or more unexplained, the right one some thousandths. Half a turn of a zero does
not change the residual but the signs: gravity would act upwards, or the rods' coupling be negative.
"""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import OtherMotionError, TrialError
from cdp_ident.trial.balance import WINDOW, Motion
from cdp_ident.trial.encoder_scale import best_scale
from cdp_ident.trial.lumped import Lumped
from cdp_ident.trial.meaning import Balance, balance_of, in_model_angles
from cdp_ident.trial.options import OuterAngle, TrialOptions, Zero
from cdp_ident.trial.other_motions import may_be_rods, still_joint, uncoupled
from cdp_ident.trial.wording import KEYS, Wording

Mask = npt.NDArray[np.bool_]

GOOD = 0.02
"""Up to this unexplained share of the acceleration, there is no evidence against a meaning."""
_LOOKED_AT = 0.005
"""Unexplained share from which it is looked whether readings are two or four times the angles."""
_LOCKED = 0.01
"""A joint whose speed is less than this share of the inner rod's does not turn."""
_MUCH_BETTER = 0.5
"""Another meaning must leave less than this share of the residual to speak against the one given."""
_CLEAR = 0.01
"""Least coupling, and least ratio of the rods' gravity terms, that are more than an error of the fit."""
EVIDENT = 0.1
"""Unexplained share up to which a meaning explains the motion, and wrong signs are evidence of a wrong zero."""


def check_conventions(
    motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions, wording: Wording = KEYS
) -> tuple[Balance | None, list[str]]:
    """Compare what the options say about the angles with the balance of forces.

    Args:
        motions: of the recorded joints.
        moving: of each motion, the windows (as many as `balance.windows` returns) that show one.
        options: what the angles are taken to mean.
        wording: how the user writes options.

    Returns:
        The balance under that meaning, or None where there is too little motion for one, and warnings.

    Raises:
        TrialError: the data contradict the options and `options.conventions` is "refuse".
    """
    given = balance_of(motions, moving, options)
    if looks := still_joint(motions, moving):
        if options.conventions == "refuse":
            raise OtherMotionError(f"this is no double pendulum: {looks}; {wording.insist}")
        return given, [f"this is no double pendulum: {looks}"]
    if given is None:
        return None, ["there is too little motion to check the joints' conventions or to tell a hand from free motion"]
    if _is_locked(motions, moving, options):
        raise TrialError("the outer joint does not turn: this is not the motion of a double pendulum")
    others = [other for other in possible_meanings(motions, moving, options) if other[0] != options]
    best, fit = min(others, key=lambda other: other[1].unexplained, default=(options, given.lumped))
    unexplained = given.lumped.unexplained
    possible = given.lumped.turned is not None
    factor = _MUCH_BETTER if possible else 1.0
    least = min(unexplained, fit.unexplained)
    from_zero = wording is KEYS and options.zero == "upright" and options.scale_from == "hanging"
    scaled = None
    if least > _LOOKED_AT:
        scaled = best_scale(motions, moving, options, any_factor=least > GOOD, from_zero=from_zero)
    if scaled and scaled[1].unexplained < min(GOOD, _MUCH_BETTER * least):
        contradiction = _wrong_scale(options, *scaled, given.lumped, wording)
    elif best != options and unexplained > GOOD and fit.unexplained < min(factor * unexplained, EVIDENT):
        contradiction = _better(options, best, given.lumped, fit, wording)
    elif not may_be_rods(given.lumped) and (looks := uncoupled(motions, moving, options)):
        contradiction = f"this is no double pendulum: {looks}"
    elif unexplained > EVIDENT:
        contradiction = (
            f"the motion is not that of a free double pendulum: {unexplained:.1%} of the inner rod's "
            "acceleration is explained neither by gravity, coupling and friction nor by another meaning of the "
            "angles: check columns, units and times; if a hand or motors move the rods for long, take the part without "
            f"them by {wording.name('start')} and {wording.name('stop')}"
        )
    elif not given.lumped.is_mechanism and given.lumped.has_certain_signs and (possible or unexplained > GOOD):
        contradiction = _wrong_signs(options, given.lumped, wording)
    else:
        warnings = [_remains(unexplained)] if unexplained > GOOD else []
        if not (given.lumped.is_mechanism and given.lumped.has_certain_signs):
            warnings.append(
                "the motion is too small, too short or too noisy to tell what the angles mean: make sure that "
                f"{wording.setting('zero', options.zero)} and {wording.setting('outer_angle', options.outer_angle)} "
                "are right"
            )
        elif best != options and _stands(fit) and fit.unexplained < max(unexplained / _MUCH_BETTER, GOOD / 2):
            warnings.append(_cannot_tell(options, best, given.lumped, fit, wording))
        return given, warnings
    if options.conventions == "refuse":
        raise (OtherMotionError if looks else TrialError)(f"{contradiction}; {wording.insist}")
    return given, [contradiction]


def possible_meanings(
    motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions
) -> list[tuple[TrialOptions, Lumped]]:
    """Return the meanings of the outer angle that make a double pendulum, and how forces balance with each."""
    meanings = [
        replace(options, outer_angle=outer_angle, outer_sign=outer_sign)
        for outer_angle, outer_sign in itertools.product(get_args(OuterAngle), (1, -1))
    ]
    fits = [(meaning, found.lumped) for meaning in meanings if (found := balance_of(motions, moving, meaning))]
    return [(meaning, fit) for meaning, fit in fits if fit.turned is not None]


def _is_locked(motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions) -> bool:
    """Return whether the outer rod turns with the inner one where the rods move."""
    half = WINDOW // 2
    parts = [
        in_model_angles(motion, options).rates[half : half + len(mask)][mask]
        for motion, mask in zip(motions, moving, strict=True)
    ]
    rates = np.concatenate(parts)
    return bool(np.std(rates[:, 1] - rates[:, 0]) < _LOCKED * np.std(rates[:, 0]))


def _stands(fit: Lumped) -> bool:
    """Return whether the fit is a pendulum with a common error of both zeros."""
    return fit.turned in ("", "both")


def changes(options: TrialOptions, other: TrialOptions, fit: Lumped, wording: Wording) -> str:
    """Return which options would have to be set to what, for another meaning of the angles."""
    if fit.turned == "both":
        other = replace(other, zero=_opposite(other.zero))
    names = ("inner_unit", "outer_unit", "outer_angle", "outer_sign", "zero")
    settings = [
        wording.setting(name, getattr(other, name)) for name in names if getattr(other, name) != getattr(options, name)
    ]
    if fit.turned in ("inner", "outer"):
        settings.append(f"the {fit.turned} joint's zero half a turn on")
    return " and ".join(settings)


def _opposite(zero: Zero) -> Zero:
    return "hanging" if zero == "upright" else "upright"


def _better(options: TrialOptions, other: TrialOptions, given: Lumped, fit: Lumped, wording: Wording) -> str:
    return (
        f"the data contradict {wording.setting('outer_angle', options.outer_angle)} with "
        f"{wording.setting('outer_sign', options.outer_sign)}, which leaves {given.unexplained:.1%} of the inner rod's "
        f"acceleration unexplained: {changes(options, other, fit, wording)} leaves {fit.unexplained:.1%}; set that"
    )


def _wrong_scale(options: TrialOptions, other: TrialOptions, fit: Lumped, given: Lumped, wording: Wording) -> str:
    """Say by which factor readings are larger than the angles."""
    changed = [
        joint for joint in ("inner", "outer") if getattr(other, f"{joint}_scale") != getattr(options, f"{joint}_scale")
    ]
    factors = {joint: f"{getattr(other, f'{joint}_scale'):.4g}" for joint in changed}
    whose = f"the {changed[0]} joint's readings are" if len(changed) == 1 else "the readings of both joints are"
    options_of = {f"{joint}_scale": factor for joint, factor in factors.items()}
    if other.scale_from != options.scale_from:
        options_of["scale_from"] = other.scale_from
    settings = " and ".join(wording.setting(name, value) for name, value in options_of.items())
    times = " and ".join(dict.fromkeys(factors.values()))
    return (
        f"{whose} {times} times the angle: {settings} leaves {fit.unexplained:.1%} of the inner rod's "
        f"acceleration unexplained instead of {given.unexplained:.1%}; check the counts per turn, or set that"
    )


def _cannot_tell(options: TrialOptions, other: TrialOptions, given: Lumped, fit: Lumped, wording: Wording) -> str:
    return (
        f"the data cannot tell {wording.setting('outer_angle', options.outer_angle)} ({given.unexplained:.1%} "
        f"unexplained) from {changes(options, other, fit, wording)} ({fit.unexplained:.1%}): make sure that it is "
        "right"
    )


def _remains(unexplained: float) -> str:
    return (
        f"{unexplained:.1%} of the inner rod's acceleration is explained neither by gravity, coupling and friction nor "
        "by noise: a zero, a unit, a time or a marker that is off, or an effect beyond these"
    )


def _wrong_signs(options: TrialOptions, given: Lumped, wording: Wording) -> str:
    """Say what half a turn of one zero would put right."""
    A, _, _, _, G1, G2, *_ = given.values
    evidence = f"gravity terms of the rods {G1:+.1f} and {G2:+.1f} 1/s^2, coupling {A:+.2f}; all must be positive"
    if given.turned == "both":
        right = wording.setting("zero", _opposite(options.zero))
        return f"the data contradict {wording.setting('zero', options.zero)} ({evidence}): set {right}"
    is_clear = A < -_CLEAR and min(abs(G1), abs(G2)) > _CLEAR * max(abs(G1), abs(G2), 1.0)
    if is_clear and (G1 < 0) != (G2 < 0):
        joint = "inner" if G1 < 0 else "outer"
        return f"the zero of the {joint} joint is half a turn from where it is taken to be ({evidence}): set it anew"
    return f"no double pendulum moves like this ({evidence}): check the joints' names, signs and units"
