"""What long windows showed, fitted over short ones, where the motion cannot be followed for long.

A joint whose dry friction varies by chance, or whatever else no model has, adds up along a window. Long windows show
weak and slow effects, and so decide which effects there are; but a model that leaves many times the noise there has
values, and zeros of each trial, that are bent by what adds up. These are fitted over windows that end before much does.
"""

from dataclasses import dataclass

import numpy as np

from cdp_ident.errors import IdentificationError
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.progress import InterruptedSelectionError, Progress
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.zeros import fit_zeros_by_trial


@dataclass(frozen=True)
class LongerWindows:
    """Windows over which the motion could not be followed."""

    duration: float
    """[s]"""
    error: float
    """Over held-out motion [rad]."""
    selection: Selection
    """What they showed."""


def fitted_over_shorter(longer: Selection, progress: Progress) -> Selection | None:
    """Return a selection's effects fitted over shorter windows, their names as sure as they were; None if they cannot.

    Args:
        longer: over long windows.
        progress: of a selection over short ones, with the paper's model.
    """
    before, interrupted = progress.current, False
    try:
        progress.current = progress.adopted(longer.after)
        fit_zeros_by_trial(progress)
        progress.reweigh()
    except InterruptedSelectionError:
        interrupted = True
    except (IdentificationError, np.linalg.LinAlgError) as error:
        progress.fail(f"what longer windows show could not be fitted over these: {error}")
    after = progress.current
    if after is before:
        return None
    places = [longer.after.place_of(label) for label in after.model.labels]
    return Selection(
        before=before,
        after=after,
        steps=(*longer.steps, *progress.steps),
        without=tuple(progress.without_each(after, [[index] for index in range(len(after.model.effects))])),
        also_possible=tuple(longer.also_possible[place] for place in places),
        certainty=tuple(longer.certainty[place] for place in places),
        failures=(*longer.failures, *progress.failures),
        interrupted=longer.interrupted or interrupted,
        looked_in=len(after.fit.windows) * longer.looked_in // len(longer.after.fit.windows),
    )


def preferred(as_before: Selection | None, anew: Selection) -> Selection:
    """Return which of two selections over the same windows is better: the one that longer windows showed, or another.

    What longer windows showed was also confirmed there; others must predict much better.
    """
    if as_before is None:
        return anew
    least = (1.0 - thresholds.LARGE_SHARE) * as_before.after.validation.rmse()
    return anew if anew.after.validation.rmse() < least else as_before
