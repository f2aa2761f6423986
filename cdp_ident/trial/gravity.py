# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What gravity tells of readings: their unit, where a counter of a few bits began, and whether a camera leans."""

import itertools
from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import TrialError
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.trial.conventions import instead
from cdp_ident.trial.joints import Samples, in_radians, model_angles
from cdp_ident.trial.lumped import gravity_directions
from cdp_ident.trial.meaning import EVIDENT, GOOD, MUCH_BETTER, Balance, Recorded, balance_of, best_of, outer_meanings
from cdp_ident.trial.options import TrialOptions, Unit
from cdp_ident.trial.other_motions import may_be_rods, too_far
from cdp_ident.trial.recorded_motion import recorded_motion

_WIDE = 4.0 * np.pi
"""Readings that change by less are no swing in a smaller unit."""
_SMALLER: tuple[Unit, ...] = ("degrees", "gradians", "milliradians")
"""The likeliest first: one that is less so must leave far less."""


def gravity_of(samples: Samples, options: TrialOptions) -> Array | None:
    """Return how far gravity is from where each rod's angle takes it to be (2,) [rad]; None with too little motion."""
    recorded = _recorded(samples, options)
    balance = balance_of(recorded, options) if recorded else None
    return gravity_directions(balance.trusted) if balance else None


def in_right_ranges(samples: Samples, options: TrialOptions) -> Samples:
    """Return samples whose counters of a few bits began in the range in which gravity pulls down.

    They are left as they are where the motion is too little to tell.
    """
    off = gravity_of(samples, options) if any(samples.ranges) else None
    if off is None:
        return samples
    still, added = model_angles(np.zeros((1, 2)), options), np.asarray(np.zeros((1, 2)))
    sizes = in_radians(np.array([samples.ranges]), options)[0]
    for joint in np.flatnonzero(sizes):
        most = max(1, round(np.pi / sizes[joint]))
        tried = np.repeat(added, 2 * most + 1, axis=0)
        tried[:, joint] = np.arange(-most, most + 1) * samples.ranges[joint]
        turned = (model_angles(in_radians(tried, options), options) - still)[:, joint]
        added = tried[[np.argmin(np.abs(np.angle(np.exp(1j * (turned - off[joint])))))]]
    return replace(samples, angles=samples.angles + added)


def found_units(samples: Samples, options: TrialOptions) -> tuple[Balance | None, Balance | None]:
    """Return the balance of forces with joints in other units, if need be, and that with the units given.

    Both are the same where no other units explain far more, and None where nothing can be told.
    """
    given = options.inner_unit, options.outer_unit
    wide = _wide(samples, options)
    before, best = _best(samples, options), None
    far_less = MUCH_BETTER * before.lumped.unexplained if before else np.inf
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
            is_likely = tried and may_be_rods(tried.lumped) and tried.lumped.turned in ("", "both")
            if tried and is_likely and tried.lumped.unexplained < least:
                best, least = tried, tried.lumped.unexplained
        if best and best.lumped.unexplained <= GOOD:
            break
    if best is None:
        return before, before
    most = EVIDENT if best.meaning.inner_unit == best.meaning.outer_unit else GOOD
    return (best if best.lumped.unexplained <= min(most, far_less) else before), before


def smaller_units_found(samples: Samples, options: TrialOptions) -> str:
    """Say which joints are in degrees or such units, with the settings that put it right; empty if none needs that."""
    if not (options.all_settable and np.any(_wide(samples, options))):
        return ""
    found, before = found_units(samples, options)
    if found is None or found is before:
        return ""
    units = {joint: unit for joint in JOINTS if (unit := getattr(found.meaning, f"{joint}_unit")) in _SMALLER}
    whose = "both joints are" if len(units) > 1 else f"the {''.join(units)} joint is"
    return instead(f"{whose} in {' and '.join(dict.fromkeys(units.values()))}", options, found, before)


def _wide(samples: Samples, options: TrialOptions) -> Mask:
    """Return which joints (2,) turn too far by their readings."""
    turned = in_radians(samples.angles, options) / [options.inner_scale, options.outer_scale]
    return np.asarray(np.ptp(turned, axis=0) > _WIDE)


def _best(samples: Samples, options: TrialOptions) -> Balance | None:
    """Return the balance under the meaning of the outer angle that explains most; None where it cannot be told."""
    recorded = _recorded(samples, options)
    return None if recorded is None or too_far(recorded, options) else best_of(outer_meanings(recorded, options))


def _recorded(samples: Samples, options: TrialOptions) -> Recorded | None:
    """Return the motion in samples; None where there is none long enough, which is told where a trial is looked for."""
    try:
        return recorded_motion(samples, options)
    except TrialError:
        return None
