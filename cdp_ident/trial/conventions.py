# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Check of the angles' conventions by the physics of the motion itself.

Of the meanings that the outer angle can have, only the right one satisfies the balance of forces (`balance`): the
others leave a tenth of the acceleration or more unexplained, the right one some thousandths. Half a turn of a zero does
not change the residual but the signs: gravity would act upwards, or the rods' coupling be negative. The unit of
readings, where a counter of a few bits began, and whether a camera leans show in the same way.

Of one pendulum, whatever stands in the other column, nothing is coupled: the equation of an outer rod holds with
nothing but zeros.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import OtherMotionError, TrialError
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.trial.joints import Samples, in_radians, model_angles
from cdp_ident.trial.lumped import gravity_directions
from cdp_ident.trial.meaning import (
    EVIDENT,
    GOOD,
    MUCH_BETTER,
    SOME,
    Balance,
    balance_of,
    best_of,
    explains_more,
    in_model_angles,
    other_meanings,
    outer_meanings,
)
from cdp_ident.trial.mechanisms import HOLDS, Pendulum, driven, one_pendulum, other_mechanism, pendulum, pendulum_of
from cdp_ident.trial.options import TrialOptions, Unit, Zero
from cdp_ident.trial.recorded_motion import Recorded, recorded_motion

_NONE = "this is no double pendulum"
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
_STILL = 0.01
"""A joint whose speed varies by less than this share of the other's does not swing."""
_FASTEST = 50.0
"""Beyond this speed [rad/s], readings are of another unit, and tell nothing of the other joint."""
_FAR_OFTEN = 0.1
"""Share of steps by more than a quarter of a turn that no swing has which is measured often enough."""
_WIDE = 4.0 * np.pi
"""Readings that change by less are no swing in a smaller unit."""
_NO_TURN = 1e9
"""Readings in a radian, of what does not wrap."""
_SMALLER: tuple[Unit, ...] = ("degrees", "gradians", "milliradians")
"""The likeliest first: one that is less so must leave far less."""


def check_conventions(recorded: Recorded, options: TrialOptions) -> tuple[Balance | None, list[str]]:
    """Compare what the options say about the angles with the balance of forces.

    Returns the balance under that meaning, or None where there is too little motion for one, and warnings.

    Raises:
        TrialError: a joint does not turn, or the data contradict the options and `options.conventions` is "refuse".
    """
    if looks := _still_joint(recorded, options):
        raise OtherMotionError(f"{_NONE}: {looks}")
    fits = outer_meanings(recorded, options)
    given = balance_of(recorded, options)
    other = one_pendulum(recorded, fits, given)
    if not other and (far := _too_far(recorded, options)):
        raise TrialError(far)
    if given is None:
        if other and options.conventions == "refuse":
            raise OtherMotionError(f"{_NONE}: it looks like {other.words}; {options.insist}")
        return None, ["there is too little motion to check the joints' conventions or to tell a hand from free motion"]
    best = best_of(fit for fit in fits if fit.meaning != options) or given
    if given.lumped.is_mechanism and given.lumped.may_be_rods and given.lumped.beyond <= SOME:
        return given, _doubts(given, best)  # nothing speaks against what holds up to noise
    contradiction = _contradiction(recorded, given, best, other)
    looks = "" if contradiction else other_mechanism(recorded, fits, given, other)
    contradiction = f"{_NONE}: {looks}" if looks else contradiction or _impossible(given)
    if contradiction and options.conventions == "refuse":
        is_other = looks or given.lumped.unexplained > EVIDENT
        raise (OtherMotionError if is_other else TrialError)(f"{contradiction}; {options.insist}")
    return given, [contradiction] if contradiction else _doubts(given, best)


def _still_joint(recorded: Recorded, options: TrialOptions) -> str:
    """Return that a joint does not turn while the other does, in words; empty where both turn or none."""
    if not any(map(np.any, recorded.moving)):
        return ""

    def speed(rates: Sequence[Array]) -> Array:
        return np.std(np.concatenate([of_motion - of_motion.mean(axis=0) for of_motion in rates]), axis=0)

    inner, outer = speed([motion.rates for motion in recorded.motions])
    # The outer rod may turn with the inner one.
    _, apart = speed(
        [np.diff(in_model_angles(motion, options).rates, axis=1, prepend=0.0) for motion in recorded.motions]
    )
    still = _STILL * np.minimum([outer, inner], _FASTEST)
    joint = "inner" if inner < still[0] else "outer" if min(outer, apart) < still[1] else ""
    return joint and f"the {joint} joint does not turn while the other does: one pendulum, or a column that is no angle"


def _too_far(recorded: Recorded, options: TrialOptions) -> str:
    """Return that readings cannot be of their unit, as a joint turns too far by them, in words; empty if none does."""
    scales = options.inner_scale, options.outer_scale
    steps = [np.abs(np.diff(piece.samples.angles, axis=0)) / scales for piece in recorded.pieces]
    far = np.mean(np.concatenate([np.zeros((1, 2)), *steps]) > np.pi / 2, axis=0) > _FAR_OFTEN
    if not np.any(far):
        return ""
    joint = JOINTS[int(np.argmax(far))]
    how = f"{joint}_scale to what it reads in a radian, and scale_from: zero" if options.all_settable else "its unit"
    return (
        f"the {joint} joint turns by more than a quarter of a turn from sample to sample: its readings are no "
        f"{getattr(options, f'{joint}_unit')} (counts of an encoder?): set {how}"
    )


def _contradiction(recorded: Recorded, given: Balance, best: Balance, mechanism: Pendulum | None) -> str:
    """Say which other meaning of the angles explains the motion; nothing where none does so far better.

    `best` is that of the other meanings of the outer angle, and `mechanism` what else moves so.
    """
    options, unexplained = given.meaning, given.lumped.unexplained
    left_so = mechanism.unexplained if mechanism else np.inf
    # Whose equation holds beside something that acts in the other joint is no rod in other units.
    left_beside = min(left_so, HOLDS if driven(given) else np.inf)
    least = min(unexplained, best.lumped.unexplained, left_beside)
    beyond = min(given.lumped.beyond, best.lumped.beyond) if np.isinf(left_beside) else 0.0
    if mechanism and not best.holds:
        beyond = 1.0  # though the one pendulum leaves nothing, two rods may hold up to noise
    # Errors of motors' torques may look like other zeros or factors.
    if (least > _LOOKED_AT or beyond > SOME) and options.input != "joints":
        others = [of for of in other_meanings(recorded, options, least, beyond) if of and (of.holds or not mechanism)]
        possible = [of for of in others if of.lumped.unexplained < GOOD and explains_more(of, least, beyond)]
        if possible:
            other = min(possible, key=lambda other: other.lumped.misfit)
            return _instead(_other_words(options, other.meaning), options, other, given)
    most = max(MUCH_BETTER * unexplained, GOOD if given.lumped.turned is None else 0.0)
    is_other = best is not given and best.lumped.has_certain_signs
    # Half a turn of one zero beside another meaning is rather something else than both at once.
    most = min(most, EVIDENT if best.lumped.turned in ("", "both") else GOOD, left_so)
    is_much = unexplained > GOOD or (best.holds and explains_more(best, 0.0, given.lumped.beyond))
    if not is_other or not is_much or best.lumped.unexplained >= most:
        return ""
    said = [options.setting(name, getattr(options, name)) for name in ("outer_angle", "outer_sign")]
    return _instead(f"the data contradict {' with '.join(said)}", options, best, given)


def _impossible(given: Balance) -> str:
    """Say why no double pendulum moves as the angles say; nothing where one may."""
    lumped = given.lumped
    # What is certain to be rods may have any effects. All else has to hold up to what noise and smoothing leave.
    if not lumped.may_be_rods and lumped.unexplained > (EVIDENT if lumped.beyond <= SOME else GOOD):
        if given.meaning.input == "joints":
            return ""  # what motors do may differ so far from what is recorded of them
        return (
            f"the motion is not that of a free double pendulum: {lumped.unexplained:.1%} of the inner rod's "
            "acceleration is explained neither by gravity, coupling and friction nor by another meaning of the "
            f"angles: {driven(given) or 'check columns, units and times'}; if a hand or motors move the rods for "
            f"long, take the part without them by {given.meaning.called('start')} and {given.meaning.called('stop')}"
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
        what_else = "a zero, a unit, a time or a marker that is off, or an effect beyond these"
        warnings.append(
            f"{lumped.unexplained:.1%} of the inner rod's acceleration is explained neither by gravity, coupling and "
            f"friction nor by noise: {driven(given) or what_else}"
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


def _instead(wrong: str, options: TrialOptions, other: Balance, given: Balance | None) -> str:
    """Return what is wrong, which settings explain the motion, and how much better than those given."""
    least, before = (f"{of.lumped.unexplained if of else np.nan:.1%}" for of in (other, given))
    than = f" instead of {before}" if before not in (least, f"{np.nan:.1%}", f"{np.inf:.1%}") else ""
    left = f"{least} of the inner rod's acceleration unexplained{than}"
    remedy = "check the counts per turn, or set that" if "times the angle" in wrong else "set that"
    return f"{wrong}: {_changes(options, other)} leaves {left}; {remedy}"


def _other_words(options: TrialOptions, other: TrialOptions) -> str:
    """Say what is wrong: which joint is which, the zeros, or the factor by which readings are larger than angles."""
    changed = _changed(options, other)
    for name, what in _WRONG.items():
        if name in changed:
            return what
    factors = {name: f"{factor:.4g}" for name, factor in changed.items() if name.endswith("_scale")}
    joints = "".join(name.removesuffix("_scale") for name in factors)
    whose = "the readings of both joints are" if len(factors) > 1 else f"the {joints} joint's readings are"
    turns = " (turns?)" if set(factors.values()) == {f"{0.5 / np.pi:.4g}"} else ""
    return f"{whose} {' and '.join(dict.fromkeys(factors.values()))} times the angle{turns}"


def gravity_of(samples: Samples, options: TrialOptions) -> Array | None:
    """Return how far gravity is from where each rod's angle takes it to be (2,) [rad]; None with too little motion."""
    recorded = _recorded(samples, options)
    balance = balance_of(recorded, options) if recorded else None
    return gravity_directions(balance.trusted) if balance else None


def in_right_ranges(samples: Samples, options: TrialOptions) -> Samples:
    """Return samples whose counters of a few bits began in the range in which gravity pulls down.

    Where it pulls far more nearly straight up in one, the zero is the opposite one: that range shows it, and no other
    one hides it. Samples are left as they are where the motion is too little to tell.
    """
    off = gravity_of(samples, options) if any(samples.ranges) else None
    if off is None:
        return samples
    sizes = in_radians(np.array(samples.ranges), options)
    # What one more range of each joint's counter adds to theta1 and theta2.
    steps = model_angles(np.diag(sizes), options) - model_angles(np.zeros((1, 2)), options)
    least, chosen = np.inf, np.zeros(2)
    for straight in (0.0, np.pi):
        more, left = np.zeros(2), np.zeros(2)
        for joint in range(2):
            most = max(1, round(np.pi / sizes[joint])) if sizes[joint] else 0
            tried = np.arange(-most, most + 1)
            away = more @ steps[:, joint] + tried * steps[joint, joint] - off[joint] - straight
            away = np.abs(np.angle(np.exp(1j * away)))
            more[joint], left[joint] = tried[np.argmin(away)], np.min(away)
        if left[0] < MUCH_BETTER * least:
            least, chosen = left[0], more
    return replace(samples, angles=samples.angles + chosen * samples.ranges)


def found_units(samples: Samples, options: TrialOptions) -> tuple[Balance | None, Balance | None]:
    """Return the balance of forces with joints in other units, if need be, and that with the units given.

    Both are the same where no other units explain far more, and None where nothing can be told.
    """
    given = options.inner_unit, options.outer_unit
    wide = _wide(samples, options)
    before, best = _best(samples, options), None
    # What is no motion of rods at all explains itself, as where one joint's readings are far larger than its angle.
    tells = before if before and (before.lumped.may_be_rods or not np.any(wide)) else None
    far_less = MUCH_BETTER * tells.lumped.unexplained if tells else np.inf
    if far_less == 0.0 or (far_less <= MUCH_BETTER * GOOD and not np.any(wide)):
        return before, before
    # Both first: with one in the wrong unit, the other may pass for a pendulum, and leave nothing either.
    others, may_be = (_SMALLER, wide) if np.any(wide) else (("turns",), [True, True])
    for other in others:
        least = MUCH_BETTER * best.lumped.unexplained if best else np.inf
        choices = [(other, unit) if it else (unit,) for unit, it in zip(given, may_be, strict=True)]
        for inner, outer in itertools.product(*choices):
            meaning = replace(options, inner_unit=inner, outer_unit=outer)
            tried = _best(samples, meaning) if meaning != options else None
            # Half a turn of one zero beside another unit is rather something else than both at once.
            is_likely = tried and tried.lumped.may_be_rods and tried.lumped.turned in ("", "both")
            if tried and is_likely and tried.lumped.unexplained < least:
                best, least = tried, tried.lumped.unexplained
    if best is None:
        return before, before
    most = EVIDENT if best.meaning.inner_unit == best.meaning.outer_unit else GOOD
    return (best if best.lumped.unexplained <= min(most, far_less) else before), before


def smaller_units_found(samples: Samples, options: TrialOptions) -> str:
    """Say which joints are in degrees or such units, with the settings that put it right; empty if none needs that.

    Raises OtherMotionError where one column is a pendulum's angle, in any unit, and the other the way of its cart.
    """
    if not np.any(_wide(samples, options)):
        return ""
    found, before = found_units(samples, options)
    rods = found.lumped.unexplained if found and found.lumped.may_be_rods else np.inf
    other, is_given = None, False
    if rods > _LOOKED_AT or found is not before:
        recorded = _recorded(samples, options)
        # One by the units given is told where what the joints mean is checked.
        is_given = bool(recorded and (other := pendulum(recorded)))
        other = other or _pendulum_on_cart(samples, options)
    if other and rods >= MUCH_BETTER * other.unexplained and not (found and found is not before and found.holds):
        is_far_better = other.unexplained < MUCH_BETTER * rods
        if not is_given and is_far_better and options.conventions == "refuse":
            raise OtherMotionError(f"{_NONE}: it looks like {other.words}; {options.insist}")
        return ""
    if found is None or found is before or not options.all_settable:
        return ""
    units = {joint: unit for joint in JOINTS if (unit := getattr(found.meaning, f"{joint}_unit")) in _SMALLER}
    whose = "both joints are" if len(units) > 1 else f"the {''.join(units)} joint is"
    return _instead(f"{whose} in {' and '.join(dict.fromkeys(units.values()))}", options, found, before)


def _pendulum_on_cart(samples: Samples, options: TrialOptions) -> Pendulum | None:
    """Return the pendulum that one column is the angle of, in one unit or another, where the other one is a length."""
    found = []
    for place, (joint, other) in enumerate(zip(JOINTS, reversed(JOINTS), strict=True)):
        of_joint = getattr(options, f"{joint}_unit")
        for unit in dict.fromkeys((of_joint, *_SMALLER)) if _wide(samples, options)[place] else (of_joint,):
            # A length does not wrap.
            recorded = _recorded(samples, replace(options, **{f"{joint}_unit": unit, f"{other}_scale": _NO_TURN}))
            one = pendulum_of(recorded, place) if recorded else None
            found.append(replace(one, words=f"{one.words} ({unit})") if one and one.is_moved else None)
    return min(filter(None, found), key=lambda one: one.unexplained, default=None)


def _wide(samples: Samples, options: TrialOptions) -> Mask:
    """Return which joints (2,) turn too far by their readings."""
    turned = in_radians(samples.angles, options) / [options.inner_scale, options.outer_scale]
    return np.asarray(np.ptp(turned, axis=0) > _WIDE)


def _best(samples: Samples, options: TrialOptions) -> Balance | None:
    """Return the balance under the meaning of the outer angle that explains most; None where it cannot be told."""
    recorded = _recorded(samples, options)
    return None if recorded is None or _too_far(recorded, options) else best_of(outer_meanings(recorded, options))


def _recorded(samples: Samples, options: TrialOptions) -> Recorded | None:
    """Return the motion in samples; None where there is none long enough, which is told where a trial is looked for."""
    try:
        return recorded_motion(samples, options)
    except TrialError:
        return None
