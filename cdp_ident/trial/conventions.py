# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Check of the angles' conventions by the physics of the motion itself.

Of the meanings that the outer angle can have, only the right one satisfies the balance of forces (`balance`): the
others leave a tenth of the acceleration or more unexplained, the right one some thousandths. Half a turn of a zero does
not change the residual but the signs: gravity would act upwards, or the rods' coupling be negative.
"""

from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from cdp_ident.errors import OtherMotionError, TrialError
from cdp_ident.trial.meaning import (
    EVIDENT,
    GOOD,
    MUCH_BETTER,
    TURNS,
    Balance,
    Recorded,
    balance_of,
    best_of,
    best_scale,
    exchanged,
    outer_meanings,
    with_other_zeros,
)
from cdp_ident.trial.options import TrialOptions, Zero
from cdp_ident.trial.other_motions import may_be_rods, still_joint, too_far, uncoupled, weightless

_LOOKED_AT = 0.005
"""Unexplained share from which it is looked whether readings are two or four times the angles."""
_OPPOSITE: Mapping[Zero, Zero] = {"upright": "hanging", "hanging": "upright"}
_WRONG = {
    "inner_joint": "the joints are exchanged",
    "cart_joint": "the cart's readings are no metres",
    **dict.fromkeys(("inner_offset", "outer_offset"), "the joints' zeros are elsewhere"),
}
"""What is wrong where an option must be another one."""
_CLEAR = 0.01
"""Least coupling, and least ratio of the rods' gravity terms, that are more than an error of the fit."""


def check_conventions(recorded: Recorded, options: TrialOptions) -> tuple[Balance | None, list[str]]:
    """Compare what the options say about the angles with the balance of forces.

    Args:
        recorded: the motion of the recorded joints.
        options: what the angles are taken to mean.

    Returns:
        The balance under that meaning, or None where there is too little motion for one, and warnings.

    Raises:
        TrialError: a joint does not turn, or the data contradict the options and `options.conventions` is "refuse".
    """
    if looks := still_joint(recorded, options):
        raise OtherMotionError(f"this is no double pendulum: {looks}")
    if far := too_far(recorded, options):
        raise TrialError(far)
    given = balance_of(recorded, options)
    if given is None:
        return None, ["there is too little motion to check the joints' conventions or to tell a hand from free motion"]
    fits = outer_meanings(recorded, options)
    best = best_of(fit for fit in fits if fit.meaning != options) or given
    contradiction = _contradiction(recorded, given, best)
    is_known = contradiction or may_be_rods(given.lumped)
    looks = "" if is_known else uncoupled(recorded.motions, fits) or weightless(recorded, given)
    contradiction = f"this is no double pendulum: {looks}" if looks else contradiction or _impossible(given)
    if contradiction and options.conventions == "refuse":
        is_other = looks or given.lumped.unexplained > EVIDENT
        raise (OtherMotionError if is_other else TrialError)(f"{contradiction}; {options.insist}")
    return given, [contradiction] if contradiction else _doubts(given, best)


def _contradiction(recorded: Recorded, given: Balance, best: Balance) -> str:
    """Say which other meaning of the angles explains the motion; nothing where none does so far better.

    `best` is that of the other meanings of the outer angle.
    """
    options, unexplained = given.meaning, given.lumped.unexplained
    least = min(unexplained, best.lumped.unexplained)
    # Errors of motors' torques may look like other zeros or factors.
    if least > _LOOKED_AT and options.input != "joints":
        others = _others(recorded, options, least)
        possible = [other for other in others if other and other.lumped.unexplained < min(GOOD, MUCH_BETTER * least)]
        if possible:
            other = min(possible, key=lambda other: other.lumped.unexplained + other.lumped.spread)
            return instead(_other_words(options, other.meaning), options, other, given)
    most = unexplained * (MUCH_BETTER if given.lumped.turned is not None else 1.0)
    is_other = best is not given and best.lumped.has_certain_signs
    if not is_other or unexplained <= GOOD or best.lumped.unexplained >= min(most, EVIDENT):
        return ""
    said = [options.setting(name, getattr(options, name)) for name in ("outer_angle", "outer_sign")]
    return instead(f"the data contradict {' with '.join(said)}", options, best, given)


def _others(recorded: Recorded, options: TrialOptions, least: float) -> Iterator[Balance | None]:
    """Yield the balances with readings over a factor and, where much is left, with other zeros and joints exchanged."""
    from_zero = options.zero == "upright" and options.scale_from == "hanging"
    yield best_scale(recorded, options, any_factor=least > GOOD, from_zero=from_zero)
    if least > GOOD:
        moved = with_other_zeros(recorded, outer_meanings(recorded, options))
        yield best_of(other for other in moved if other.lumped.is_certain)
        turned = replace(options, inner_joint=options.outer_joint, outer_joint=options.inner_joint)
        yield best_of(other for other in outer_meanings(exchanged(recorded), turned) if may_be_rods(other.lumped))
    if least > GOOD and options.all_settable and any(np.any(motion.cart) for motion in recorded.motions):
        free = balance_of(recorded, replace(options, cart_joint=""))
        yield free if free and may_be_rods(free.lumped) else None


def _impossible(given: Balance) -> str:
    """Say why no double pendulum moves as the angles say; nothing where one may."""
    lumped = given.lumped
    if lumped.unexplained > EVIDENT:
        if given.meaning.input == "joints":
            return ""  # what motors do may differ so far from what is recorded of them
        return (
            f"the motion is not that of a free double pendulum: {lumped.unexplained:.1%} of the inner rod's "
            "acceleration is explained neither by gravity, coupling and friction nor by another meaning of the "
            "angles: check columns, units and times; if a hand or motors move the rods for long, take the part without "
            f"them by {given.meaning.called('start')} and {given.meaning.called('stop')}"
        )
    A, _, _, _, G1, G2, *_ = lumped.values
    # No half turns of zeros give such signs; inertias alone may be as wrong as a small swing tells little of them.
    may_tell = lumped.turned is not None or lumped.unexplained > GOOD or A * G1 * G2 < 0
    if lumped.is_mechanism or not (lumped.has_certain_signs and may_tell):
        return ""
    evidence = f"gravity terms of the rods {G1:+.1f} and {G2:+.1f} 1/s^2, coupling {A:+.2f}; all must be positive"
    if lumped.turned == "both":
        zero = given.meaning.zero
        right = given.meaning.setting("zero", _OPPOSITE[zero])
        return f"the data contradict {given.meaning.setting('zero', zero)} ({evidence}): set {right}"
    is_clear = A < -_CLEAR and min(abs(G1), abs(G2)) > _CLEAR * max(abs(G1), abs(G2), 1.0)
    if is_clear and (G1 < 0) != (G2 < 0):
        joint = "inner" if G1 < 0 else "outer"
        return f"the zero of the {joint} joint is half a turn from where it is taken to be ({evidence}): set it anew"
    return f"no double pendulum moves like this ({evidence}): check the joints' names, signs and units"


def _doubts(given: Balance, best: Balance) -> list[str]:
    """Return warnings of a meaning that the motion does not contradict."""
    options, lumped, other = given.meaning, given.lumped, best.lumped
    warnings = []
    if lumped.unexplained > GOOD:
        warnings.append(
            f"{lumped.unexplained:.1%} of the inner rod's acceleration is explained neither by gravity, coupling and "
            "friction nor by noise: a zero, a unit, a time or a marker that is off, or an effect beyond these"
        )
    outer_angle = options.setting("outer_angle", options.outer_angle)
    as_good = other.unexplained < max(lumped.unexplained / MUCH_BETTER, GOOD / 2)
    if not lumped.is_certain:
        warnings.append(
            "the motion is too small, too short or too noisy to tell what the angles mean: make sure that "
            f"{options.setting('zero', options.zero)} and {outer_angle} are right"
        )
    elif best is not given and other.turned in ("", "both") and as_good:
        warnings.append(
            f"the data cannot tell {outer_angle} ({lumped.unexplained:.1%} unexplained) from "
            f"{_changes(options, best)} ({other.unexplained:.1%}): make sure that it is right"
        )
    return warnings


def _changed(options: TrialOptions, meaning: TrialOptions) -> dict[str, Any]:
    """Return the values of another meaning by the options that would have to be set for it."""
    names = [field.name for field in fields(options)]
    return {name: value for name in names if (value := getattr(meaning, name)) != getattr(options, name)}


def _changes(options: TrialOptions, other: Balance) -> str:
    """Return which options would have to be set to what, for another meaning of the angles."""
    meaning, turned = other.meaning, other.lumped.turned
    if turned == "both":
        meaning = replace(meaning, zero=_OPPOSITE[meaning.zero])
    values = _changed(options, meaning)
    shown = {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in values.items()}
    settings = [options.setting(name, value or "''") for name, value in shown.items()]
    if turned in ("inner", "outer"):
        settings.append(f"the {turned} joint's zero half a turn on")
    return " and ".join(settings)


def instead(wrong: str, options: TrialOptions, other: Balance, given: Balance | None) -> str:
    """Return what is wrong, which settings explain the motion, and how much better than those given."""
    than = f" instead of {given.lumped.unexplained:.1%}" if given and np.isfinite(given.lumped.unexplained) else ""
    return (
        f"{wrong}: {_changes(options, other)} leaves {other.lumped.unexplained:.1%} of the inner rod's "
        f"acceleration unexplained{than}; "
    ) + ("check the counts per turn, or set that" if "times the angle" in wrong else "set that")


def _other_words(options: TrialOptions, other: TrialOptions) -> str:
    """Say what is wrong: which joint is which, the zeros, or the factor by which readings are larger than angles."""
    changed = _changed(options, other)
    for name, what in _WRONG.items():
        if name in changed:
            return what
    factors = {name: f"{factor:.4g}" for name, factor in changed.items() if name.endswith("_scale")}
    joints = "".join(name.removesuffix("_scale") for name in factors)
    whose = "the readings of both joints are" if len(factors) > 1 else f"the {joints} joint's readings are"
    turns = " (turns?)" if set(factors.values()) == {f"{TURNS:.4g}"} else ""
    return f"{whose} {' and '.join(dict.fromkeys(factors.values()))} times the angle{turns}"
