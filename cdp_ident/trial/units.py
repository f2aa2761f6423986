"""Whether readings that are taken for radians are degrees: gravity explains the motion in the right unit alone."""

import itertools
from dataclasses import replace

import numpy as np

from cdp_ident.errors import TrialError
from cdp_ident.trial.conventions import instead, outer_meanings
from cdp_ident.trial.joints import Samples, in_radians
from cdp_ident.trial.lumped import Lumped
from cdp_ident.trial.meaning import EVIDENT, GOOD, MUCH_BETTER
from cdp_ident.trial.options import TrialOptions, Unit
from cdp_ident.trial.recorded_motion import recorded_motion
from cdp_ident.trial.wording import KEYS

_WIDE = 4.0 * np.pi
"""Readings that change by less are no swing in degrees."""
_PART = 0.25
"""One joint that hardly moves, for its readings are taken for degrees, leaves a single pendulum, which may do."""


def found_units(samples: Samples, options: TrialOptions) -> tuple[TrialOptions, Lumped | None, Lumped | None]:
    """Return the meaning, with joints in degrees if need be, that explains the motion, and how forces balance with it.

    The last value is the balance with the units given: the same where no others explain far more.
    """
    given = options.inner_unit, options.outer_unit
    wide = np.ptp(in_radians(samples.angles, options), axis=0) > _WIDE
    # Both first: with one in the wrong unit, the other may pass for a pendulum, and leave nothing either.
    may_be = [is_wide and unit != "degrees" for unit, is_wide in zip(given, wide, strict=True)]
    choices: list[tuple[Unit, ...]] = [
        ("degrees", unit) if also else (unit,) for unit, also in zip(given, may_be, strict=True)
    ]
    units = itertools.product(*choices)
    others = [replace(options, inner_unit=inner, outer_unit=outer) for inner, outer in units if (inner, outer) != given]
    others = [other for other in others if _swings_as_the_other(samples, other)]
    as_given, before = _best(samples, options)
    tried = (_best(samples, other) for other in others)
    meaning, fit = min(tried, key=lambda found: _unexplained(found[1]), default=(options, None))
    most = EVIDENT if meaning.inner_unit == meaning.outer_unit else GOOD
    if fit is None or fit.unexplained > min(most, MUCH_BETTER * _unexplained(before)):
        return as_given, before, before
    return meaning, fit, before


def degrees_found(samples: Samples, options: TrialOptions) -> str:
    """Say which joints are in degrees, with the settings that put it right; empty where none is, or it is set so."""
    if not np.any(np.ptp(in_radians(samples.angles, options), axis=0) > _WIDE):
        return ""
    meaning, fit, before = found_units(samples, options)
    if fit is None or fit is before:
        return ""
    degrees = [joint for joint in ("inner", "outer") if getattr(meaning, f"{joint}_unit") == "degrees"]
    whose = "both joints are" if len(degrees) > 1 else f"the {''.join(degrees)} joint is"
    return instead(f"{whose} in degrees", options, meaning, before, fit, KEYS)


def _swings_as_the_other(samples: Samples, options: TrialOptions) -> bool:
    """Return whether a joint that alone is in degrees turns by no less than a part of what the other does."""
    inner, outer = np.ptp(in_radians(samples.angles, options), axis=0)
    alone = {("degrees", "radians"): inner >= _PART * outer, ("radians", "degrees"): outer >= _PART * inner}
    return bool(alone.get((options.inner_unit, options.outer_unit), True))


def _best(samples: Samples, options: TrialOptions) -> tuple[TrialOptions, Lumped | None]:
    """Return the meaning of the outer angle that explains most, and what it explains; None where it cannot be told."""
    try:
        _, motions, moving, _ = recorded_motion(samples, options)
    except TrialError:
        return options, None
    found = [
        (meaning, fit) for meaning, fit in outer_meanings(motions, moving, options).items() if fit.turned is not None
    ]
    return min(found, key=lambda pair: pair[1].unexplained, default=(options, None))


def _unexplained(fit: Lumped | None) -> float:
    return fit.unexplained if fit else np.inf
