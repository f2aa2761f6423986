# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether readings that are taken for radians are degrees: gravity explains the motion in the right unit alone."""

import itertools
from dataclasses import replace

import numpy as np

from cdp_ident.errors import TrialError
from cdp_ident.trial.conventions import instead
from cdp_ident.trial.joints import Samples, in_radians
from cdp_ident.trial.meaning import EVIDENT, GOOD, MUCH_BETTER, Balance, best_of, outer_meanings
from cdp_ident.trial.options import TrialOptions, Unit
from cdp_ident.trial.other_motions import may_be_rods, too_far
from cdp_ident.trial.recorded_motion import recorded_motion

_WIDE = 4.0 * np.pi
"""Readings that change by less are no swing in degrees."""


def found_units(samples: Samples, options: TrialOptions) -> tuple[Balance | None, Balance | None]:
    """Return the balance of forces with joints in degrees or in turns, if need be, and that with the units given.

    Both are the same where no other units explain far more, and None where nothing can be told.
    """
    given = options.inner_unit, options.outer_unit
    wide = np.ptp(in_radians(samples.angles, options), axis=0) > _WIDE
    before, best = _best(samples, options), None
    if before and before.lumped.unexplained <= GOOD and not np.any(wide):
        return before, before
    # Both first: with one in the wrong unit, the other may pass for a pendulum, and leave nothing either.
    other: Unit = "degrees" if np.any(wide) else "turns"
    may_be = wide if np.any(wide) else [True, True]
    choices: list[tuple[Unit, ...]] = [(other, unit) if it else (unit,) for unit, it in zip(given, may_be, strict=True)]
    for inner, outer in itertools.product(*choices):
        meaning = replace(options, inner_unit=inner, outer_unit=outer)
        tried = _best(samples, meaning) if meaning != options else None
        # Half a turn of one zero beside another unit is rather something else than both at once.
        is_likely = tried and may_be_rods(tried.lumped) and tried.lumped.turned in ("", "both")
        if tried and is_likely and not (best and best.lumped.unexplained <= tried.lumped.unexplained):
            best = tried
    if best is None:
        return before, before
    most = EVIDENT if best.meaning.inner_unit == best.meaning.outer_unit else GOOD
    far_less = MUCH_BETTER * before.lumped.unexplained if before else np.inf
    return (best if best.lumped.unexplained <= min(most, far_less) else before), before


def degrees_found(samples: Samples, options: TrialOptions) -> str:
    """Say which joints are in degrees, with the settings that put it right; empty where none is, or it is set so."""
    if not (options.all_settable and np.any(np.ptp(in_radians(samples.angles, options), axis=0) > _WIDE)):
        return ""
    found, before = found_units(samples, options)
    if found is None or found is before:
        return ""
    degrees = [joint for joint in ("inner", "outer") if getattr(found.meaning, f"{joint}_unit") == "degrees"]
    whose = "both joints are" if len(degrees) > 1 else f"the {''.join(degrees)} joint is"
    return instead(f"{whose} in degrees", options, found, before)


def _best(samples: Samples, options: TrialOptions) -> Balance | None:
    """Return the balance under the meaning of the outer angle that explains most; None where it cannot be told."""
    try:
        recorded = recorded_motion(samples, options)
    except TrialError:
        return None
    return None if too_far(recorded, options) else best_of(outer_meanings(recorded, options))
