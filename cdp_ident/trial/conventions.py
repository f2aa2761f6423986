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

from cdp_ident.arrays import Mask
from cdp_ident.errors import OtherMotionError, TrialError
from cdp_ident.trial.encoder_scale import best_scale
from cdp_ident.trial.lumped import Lumped
from cdp_ident.trial.meaning import EVIDENT, GOOD, MUCH_BETTER, Balance, balance_of
from cdp_ident.trial.options import OuterAngle, TrialOptions, Zero
from cdp_ident.trial.other_motions import may_be_rods, still_joint, uncoupled
from cdp_ident.trial.weak_form import Motion
from cdp_ident.trial.wording import KEYS, Wording

_LOOKED_AT = 0.005
"""Unexplained share from which it is looked whether readings are two or four times the angles."""
_SETTINGS = (
    "inner_unit",
    "outer_unit",
    "outer_angle",
    "outer_sign",
    "zero",
    "inner_scale",
    "outer_scale",
    "scale_from",
)
"""What meanings of the angles differ in."""
_CLEAR = 0.01
"""Least coupling, and least ratio of the rods' gravity terms, that are more than an error of the fit."""


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
        TrialError: a joint does not turn, or the data contradict the options and `options.conventions` is "refuse".
    """
    if looks := still_joint(motions, moving, options):
        raise OtherMotionError(f"this is no double pendulum: {looks}")
    given = balance_of(motions, moving, options)
    if given is None:
        return None, ["there is too little motion to check the joints' conventions or to tell a hand from free motion"]
    fits = outer_meanings(motions, moving, options)
    others = [(other, fit) for other, fit in fits.items() if other != options and fit.turned is not None]
    best, fit = min(others, key=lambda other: other[1].unexplained, default=(options, given.lumped))
    unexplained = given.lumped.unexplained
    possible = given.lumped.turned is not None
    factor = MUCH_BETTER if possible else 1.0
    least = min(unexplained, fit.unexplained)
    from_zero = wording is KEYS and options.zero == "upright" and options.scale_from == "hanging"
    scaled = None
    if least > _LOOKED_AT:
        scaled = best_scale(motions, moving, options, any_factor=least > GOOD, from_zero=from_zero)
    if scaled and scaled[1].unexplained < min(GOOD, MUCH_BETTER * least):
        other, fit = scaled
        contradiction = instead(_scaled_words(options, other), options, other, given.lumped, fit, wording)
    elif best != options and unexplained > GOOD and fit.unexplained < min(factor * unexplained, EVIDENT):
        said = [wording.setting(name, getattr(options, name)) for name in ("outer_angle", "outer_sign")]
        wrong = f"the data contradict {' with '.join(said)}"
        contradiction = instead(wrong, options, best, given.lumped, fit, wording)
    elif not may_be_rods(given.lumped) and (looks := uncoupled(motions, fits.values())):
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
        elif (
            best != options
            and fit.turned in ("", "both")
            and fit.unexplained < max(unexplained / MUCH_BETTER, GOOD / 2)
        ):
            warnings.append(_cannot_tell(options, best, given.lumped, fit, wording))
        return given, warnings
    if options.conventions == "refuse":
        raise (OtherMotionError if looks else TrialError)(f"{contradiction}; {wording.insist}")
    return given, [contradiction]


def outer_meanings(
    motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions
) -> dict[TrialOptions, Lumped]:
    """Return the meanings that the outer angle can have, and how forces balance with each."""
    meanings = [
        replace(options, outer_angle=outer_angle, outer_sign=outer_sign)
        for outer_angle, outer_sign in itertools.product(get_args(OuterAngle), (1, -1))
    ]
    return {meaning: found.lumped for meaning in meanings if (found := balance_of(motions, moving, meaning))}


def changes(options: TrialOptions, other: TrialOptions, fit: Lumped, wording: Wording) -> str:
    """Return which options would have to be set to what, for another meaning of the angles."""
    if fit.turned == "both":
        other = replace(other, zero=_opposite(other.zero))
    values = {name: getattr(other, name) for name in _SETTINGS if getattr(other, name) != getattr(options, name)}
    shown = {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in values.items()}
    settings = [wording.setting(name, value) for name, value in shown.items()]
    if fit.turned in ("inner", "outer"):
        settings.append(f"the {fit.turned} joint's zero half a turn on")
    return " and ".join(settings)


def instead(
    wrong: str, options: TrialOptions, other: TrialOptions, given: Lumped | None, fit: Lumped, wording: Wording
) -> str:
    """Return what is wrong, which settings explain the motion, and how much better than those given."""
    than = f" instead of {given.unexplained:.1%}" if given and np.isfinite(given.unexplained) else ""
    return (
        f"{wrong}: {changes(options, other, fit, wording)} leaves {fit.unexplained:.1%} of the inner rod's "
        f"acceleration unexplained{than}; "
    ) + ("check the counts per turn, or set that" if "times the angle" in wrong else "set that")


def _opposite(zero: Zero) -> Zero:
    return "hanging" if zero == "upright" else "upright"


def _scaled_words(options: TrialOptions, other: TrialOptions) -> str:
    """Say by which factor readings are larger than the angles."""
    factors = {
        joint: f"{factor:.4g}"
        for joint in ("inner", "outer")
        if (factor := getattr(other, f"{joint}_scale")) != getattr(options, f"{joint}_scale")
    }
    whose = "the readings of both joints are" if len(factors) > 1 else f"the {''.join(factors)} joint's readings are"
    return f"{whose} {' and '.join(dict.fromkeys(factors.values()))} times the angle"


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
