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


def degrees_found(samples: Samples, options: TrialOptions) -> str:
    """Say which joints are in degrees, with the settings that put it right; empty where none is, or it is set so."""
    given = options.inner_unit, options.outer_unit
    wide = np.ptp(in_radians(samples.angles, options), axis=0) > _WIDE
    # Both first: with one in the wrong unit, the other may pass for a pendulum, and leave nothing either.
    may_be = [is_wide and unit != "degrees" for unit, is_wide in zip(given, wide, strict=True)]
    choices: list[tuple[Unit, ...]] = [
        ("degrees", unit) if also else (unit,) for unit, also in zip(given, may_be, strict=True)
    ]
    units = itertools.product(*choices)
    others = [replace(options, inner_unit=inner, outer_unit=outer) for inner, outer in units if (inner, outer) != given]
    if not others:
        return ""
    meaning, fit = min((_best(samples, other) for other in others), key=lambda found: _unexplained(found[1]))
    _, before = _best(samples, options)
    degrees = [joint for joint in ("inner", "outer") if getattr(meaning, f"{joint}_unit") == "degrees"]
    # One joint that hardly moves, for its readings are taken for degrees, leaves a single pendulum, which may do.
    most = EVIDENT if len(degrees) > 1 else GOOD
    if fit is None or fit.unexplained > min(most, MUCH_BETTER * _unexplained(before)):
        return ""
    whose = "both joints are" if len(degrees) > 1 else f"the {''.join(degrees)} joint is"
    return instead(f"{whose} in degrees", options, meaning, before, fit, KEYS)


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


def unexplained_in(unit: Unit, samples: Samples, options: TrialOptions) -> float:
    """Return what is unexplained of samples' motion with both joints in a unit, whatever the outer angle means."""
    return _unexplained(_best(samples, replace(options, inner_unit=unit, outer_unit=unit))[1])


def _unexplained(fit: Lumped | None) -> float:
    return fit.unexplained if fit else np.inf
