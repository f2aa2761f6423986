"""Refits of a model with other effects: well enough to compare them, and predicted where that is asked for."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.cross_validation import Folds
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit, refine, refine_from_afar
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.noise_memory import is_structured

Array = npt.NDArray[np.float64]

_ROUGHLY, _CLOSELY = 1e-3, 1e-4
"""Tolerances of refits that only compare candidates, where more than noise remains and where it does not; the accepted
model is refined further."""
_HOPELESS = 1.5
"""A rival that leaves so many times the squared error of what it is to beat is not better, nor as good."""
_KEPT = 0.5
"""A refit over whole windows is good if it gains this share of what the score test predicts."""
_FEW = 10
"""Iterations of a refit that need not be repeated: those that go astray take some twenty and more."""
Condition = Callable[[Attempt], bool]
"""A condition on a model's fit alone: it does not ask for its predictions."""


def always(attempt: Attempt) -> bool:
    """Return that predictions are wanted whatever the fit is."""
    return True


def refit_without(attempt: Attempt, indices: Sequence[int]) -> Attempt | Exception:
    """Return a model without some of its effects, refitted, or why that cannot be done."""
    try:
        fit = refine(*left_after(attempt, indices), attempt.fit.windows, tolerance=_CLOSELY)
        return attempt_of(fit, attempt.folds)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return error


def left_after(attempt: Attempt, indices: Sequence[int]) -> tuple[MotionModel, Array]:
    """Return a model without some of its effects, and the values that are left."""
    model: MotionModel = attempt.model
    values: Array = attempt.fit.values
    for index in sorted(indices, reverse=True):
        model, remain = model.without_effect(index)
        values = values[remain]
    return model, values


def with_candidates(model: MotionModel, values: Array, candidates: Iterable[Candidate]) -> tuple[MotionModel, Array]:
    """Return a model with more effects, and values of its unknowns to begin a refit with."""
    for candidate in candidates:
        model = model.with_effect(candidate.active)
        values = np.concatenate([values, candidate.values])
    return model, values


def roughly(
    attempt: Attempt, to_beat: Attempt | None = None, may_win: Condition = always, from_afar: bool = False
) -> Callable[[tuple[MotionModel, Array]], Attempt | None]:
    """Return what refits a model over an attempt's windows from given values, well enough to compare it."""
    tolerance = tolerance_of(attempt.fit)

    def refit(begun: tuple[MotionModel, Array]) -> Attempt | None:
        fit = (refine_from_afar if from_afar else refine)(*begun, attempt.fit.windows, tolerance=tolerance)
        return predicted(fit, attempt.folds, to_beat, may_win)

    return refit


def refit_with(model: MotionModel, values: Array, before: Fit, expected: float) -> Fit:
    """Refine a model with more effects, over whole windows or, if that fails, over windows of growing length.

    A fit that ends after a few steps has found the minimum that the score test points to, however little that gains.
    What oscillates by itself is fitted over growing windows at once: over whole ones its frequency has many minima.

    Args:
        model: the model.
        values: (unknowns,) initial values.
        before: the fit of the model without them.
        expected: the squared error that score tests predict [rad^2].
    """
    tolerance = tolerance_of(before)
    if any(active.effect.brings_states for active in model.effects[len(before.model.effects) :]):
        return refine_from_afar(model, values, before.windows, tolerance=tolerance)
    at_once: Fit | None = None
    try:
        at_once = refine(model, values, before.windows, tolerance=tolerance)
    except IdentificationError:
        pass  # the motion cannot be computed over whole windows; over short ones it can
    else:
        gained, promised = before.squared_error - at_once.squared_error, before.squared_error - expected
        is_near = at_once.iterations <= _FEW and gained > 0.0
        if at_once.converged and (is_near or gained > _KEPT * promised):
            return at_once
    grown = refine_from_afar(model, values, before.windows, tolerance=tolerance)
    return at_once if at_once is not None and at_once.squared_error < grown.squared_error else grown


def tolerance_of(before: Fit) -> float:
    """Return how closely the refits of another model than `before` converge.

    What remains beside noise is much larger than what the last iterations gain; noise is not, and a gain of a few
    variances decides.
    """
    return _ROUGHLY if is_structured(before) else _CLOSELY


def predicted(fit: Fit, folds: Folds, to_beat: Attempt | None, may_win: Condition) -> Attempt | None:
    """Return a fitted model, with its predictions where it may win; None where it is far from what it is to beat."""
    if to_beat is not None and fit.squared_error > _HOPELESS * to_beat.fit.squared_error:
        return None
    attempt = Attempt(fit, folds)
    if may_win(attempt):
        attempt.predict()
    return attempt


def attempt_of(fit: Fit, folds: Folds) -> Attempt:
    """Return a fitted model with its predictions of each fold.

    Raises:
        IdentificationError: they cannot be computed.
    """
    attempt = Attempt(fit, folds)
    attempt.predict()
    return attempt
