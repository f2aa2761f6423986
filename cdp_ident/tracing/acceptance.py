"""What an effect must improve to be added to a model and to stay in it, and what share of the error it explains."""

from collections.abc import Sequence

import numpy as np

from cdp_ident.diagnosis.outlier_windows import explains_an_outlier
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.effects.effect import Effect
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.evidence import Attempt, Change, change
from cdp_ident.tracing.noise_memory import is_structured


def is_accepted(before: Attempt, after: Attempt, new: Sequence[int] | None = None) -> bool:
    """Return whether the effects that `after` has in addition improve the model enough, and are physical.

    They are the last ones, or those at the indices `new`.
    """
    new = range(len(before.model.effects), len(after.model.effects)) if new is None else new
    if not may_be_accepted(before, after, new):
        return False
    if any(after.model.effects[index].effect.at_an_instant for index in new):
        return change(before, after).validation > -thresholds.VALIDATION_GAIN
    return improves_enough(before, after)


def may_be_accepted(before: Attempt, after: Attempt, new: Sequence[int] | None = None) -> bool:
    """Return the same before anything is predicted: false where the fit alone rules it out."""
    new = range(len(before.model.effects), len(after.model.effects)) if new is None else new
    if any(after.at_limit(index) for index in new):
        return False
    gained = change(before, after)
    if any(after.strength(index) < _least_strength(after.model.effects[index], gained.freedom) for index in new):
        return False
    added = [after.model.effects[index].effect for index in new]
    structured, old, left = is_structured(after.fit), before.fit.squared_error, after.fit.squared_error
    once = [effect for effect in added if effect.at_an_instant]
    if once:
        # An impulse affects one window, which must be an outlier. Lost counts affect all windows from then on; where
        # more than noise would remain, they may imitate a part of something else unless they explain most of it.
        if all(not effect.moves for effect in once):
            apart = not structured or left < thresholds.SLIP_LEAVES * old
        else:
            apart = explains_an_outlier(before.fit, after.fit, thresholds.OUTLIER, thresholds.LIKE_THE_OTHERS)
        return gained.fit > thresholds.INSTANT_GAIN and apart
    # So may one harmonic, of another function of position.
    is_a_part = structured and left > thresholds.HARMONIC_LEAVES * old
    if is_a_part and any(effect.moves and effect.harmonic for effect in added):
        return False
    return fit_gains_by_more_than_chance(gained)


def _least_strength(active: ActiveEffect, freedom: float) -> float:
    """Return the least strength of an effect, in its own standard deviations (Wald's test).

    What has states of its own also gains by their initial values: oscillations that begin anew in each window imitate a
    part of whatever remains there. So its strength alone must gain what all its parameters must.

    Args:
        active: the effect.
        freedom: effective number of unknowns that were added: of a curve, all but its strengths are held by a penalty.
    """
    effect = active.effect
    if not effect.curve:
        freedom = sum(effect.brings_states or not parameter.shape for parameter in active.fitted)
    return float(np.sqrt(thresholds.least_gain(freedom)))


def improves_enough(before: Attempt, after: Attempt) -> bool:
    """Return whether the errors fall by more than chance does, on the fit and in cross-validation, and by a share."""
    gained = change(before, after)
    if not gains_by_more_than_chance(gained):
        return False
    of_fit, of_validation = (
        1.0 - new.rmse() / old.rmse() for old, new in zip(fits_of(before), fits_of(after), strict=True)
    )
    # Where more than noise would remain, a small gain may be due to another effect.
    structured = is_structured(after.fit)
    least = thresholds.STRUCTURED_SHARE if structured else thresholds.VALIDATION_SHARE
    enough = of_validation > thresholds.VALIDATION_SHARE and max(of_fit, of_validation) > least
    # In short windows a certain effect may cause only a small share of the error.
    return enough or (not structured and gained.validation > thresholds.CERTAIN)


def gains_by_more_than_chance(gained: Change) -> bool:
    """Return whether the errors fall by more than chance does, however small a share of them that is."""
    return fit_gains_by_more_than_chance(gained) and gained.validation > thresholds.VALIDATION_GAIN


def fit_gains_by_more_than_chance(gained: Change) -> bool:
    """Return the same before anything is predicted: false where the fit alone rules it out."""
    return gained.fit > thresholds.least_gain(gained.freedom)


def still_helps(with_it: Attempt, without_it: Attempt, effect: Effect) -> bool:
    """Return whether an effect still improves the model beside those that were added after it."""
    lost = change(without_it, with_it)
    least = thresholds.INSTANT_GAIN if effect.at_an_instant else thresholds.least_gain(lost.freedom)
    return lost.fit >= thresholds.STILL_HELPS * least and lost.validation >= 0


def share_explained(with_it: Attempt, without_it: Attempt, noise: float) -> float:
    """Return the ratio of explained to unexplained error: in the fit or in cross-validation, whichever is larger.

    In cross-validation the window with the largest fall is left out: in chaotic motion, a single prediction may be
    wrong, and the fall of its error means nothing.

    Args:
        with_it: the model with the effects.
        without_it: the model without them.
        noise: root mean square of both angles' noise [rad], above zero.
    """
    falls = (
        without_it.fit.rmse() ** 2 - with_it.fit.rmse() ** 2,
        _fall_without_the_largest(without_it.validation, with_it.validation),
    )
    least = (1.0 + thresholds.NOISE_KNOWN_WITHIN) * noise
    return max(
        fall / (max(now.rmse(), least) ** 2 - noise**2) for fall, now in zip(falls, fits_of(with_it), strict=True)
    )


def _fall_without_the_largest(before: Fit, after: Fit) -> float:
    """Return the fall of the mean squared error over all windows but the one where it falls most [rad^2]."""
    falls = [
        float(np.sum(window.counts * (old**2 - new**2)))
        for window, old, new in zip(after.windows, before.errors, after.errors, strict=True)
    ]
    largest = int(np.argmax(falls))
    angles = [error.shape[1] * window.independent for window, error in zip(after.windows, after.errors, strict=True)]
    samples = sum(angles) - angles[largest]
    return (sum(falls) - falls[largest]) / samples if samples else falls[largest] / sum(angles)


def fits_of(attempt: Attempt) -> tuple[Fit, Fit]:
    """Return how a model follows the motion it was fitted to, and how it predicts it fold by fold."""
    return attempt.fit, attempt.validation
