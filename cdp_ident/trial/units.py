"""Whether readings that are taken for radians are degrees: gravity explains the motion in the right unit alone."""

from dataclasses import replace

import numpy as np

from cdp_ident.errors import TrialError
from cdp_ident.trial.conventions import EVIDENT, GOOD, changes, possible_meanings
from cdp_ident.trial.joints import Samples, in_radians
from cdp_ident.trial.lumped import Lumped
from cdp_ident.trial.options import TrialOptions, Unit
from cdp_ident.trial.recorded_motion import recorded_motion
from cdp_ident.trial.wording import KEYS

_WIDE = 4.0 * np.pi
"""Readings that change by less are no swing in degrees."""
_FAR_LESS = 0.25
"""In the right unit less than this share is unexplained of what is in the other."""
_OTHERS: dict[str, tuple[Unit, Unit]] = {
    "both joints are": ("degrees", "degrees"),
    "the inner joint is": ("degrees", "radians"),
    "the outer joint is": ("radians", "degrees"),
}


def degrees_found(samples: Samples, options: TrialOptions) -> str:
    """Say which joints are in degrees, with the settings that put it right; empty where none is, or it is set so."""
    wide = np.ptp(in_radians(samples.angles, options), axis=0) > _WIDE
    others = {
        whose: _best(samples, replace(options, inner_unit=inner, outer_unit=outer))
        for whose, (inner, outer) in _OTHERS.items()
        if (inner, outer) != (options.inner_unit, options.outer_unit)
        and (inner == options.inner_unit or (wide[0] and inner == "degrees"))
        and (outer == options.outer_unit or (wide[1] and outer == "degrees"))
    }
    if not others:
        return ""
    _, given = _best(samples, options)
    whose, (meaning, fit) = min(others.items(), key=lambda other: _unexplained(other[1][1]))
    # One joint that hardly moves, for its readings are taken for degrees, leaves a single pendulum, which may do.
    most = EVIDENT if _OTHERS[whose] == ("degrees", "degrees") else GOOD
    if fit is None or fit.unexplained > min(most, _FAR_LESS * _unexplained(given)):
        return ""
    instead = f" instead of {given.unexplained:.1%}" if given and np.isfinite(given.unexplained) else ""
    return (
        f"{whose} in degrees: {changes(options, meaning, fit, KEYS)} leaves {fit.unexplained:.1%} of the inner rod's "
        f"acceleration unexplained{instead}; set that"
    )


def _best(samples: Samples, options: TrialOptions) -> tuple[TrialOptions, Lumped | None]:
    """Return the meaning of the outer angle that explains most, and what it explains; None where it cannot be told."""
    try:
        _, motions, moving, _ = recorded_motion(samples, options)
    except TrialError:
        return options, None
    found = possible_meanings(motions, moving, options)
    return min(found, key=lambda pair: pair[1].unexplained, default=(options, None))


def _unexplained(fit: Lumped | None) -> float:
    return fit.unexplained if fit else np.inf
