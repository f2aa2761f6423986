"""From an identification to the effects that explain its residual, in physical units."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.evaluation import ErrorsByRole, errors_of, evaluate
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.errors import FitFailedError, IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.physical import PhysicalValues
from cdp_ident.fit.refinement import Fit
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.parameters import groups_of, inertia_about_cart
from cdp_ident.tracing.certainty import confirmed
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.expected import ExpectedEffect
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.final_values import final_values, with_values
from cdp_ident.tracing.found_effects import FoundEffect, found_effects
from cdp_ident.tracing.in_doubt import InDoubt, added_covariance, effects_in_doubt
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.shorter_windows import LongerWindows, fitted_over_shorter, preferred
from cdp_ident.tracing.stepwise import stepwise_selection
from cdp_ident.tracing.unexplained import Unexplained, unexplained

Array = npt.NDArray[np.float64]
Stage = Literal["nominal", "search", "refined", "effects"]


_WORSE = 1.02
"""From so many times the error on, a model is worse than another one beyond chance."""


@dataclass(frozen=True)
class Withdrawn:
    """Effects that were found, and predict what was held out worse than the paper's model does."""

    effects: tuple[str, ...]
    """Their keys."""
    holdout: float
    """Error of the model with them over what was held out [rad]."""


@dataclass(frozen=True)
class Trace:
    """What an identification's residual was traced to."""

    selection: Selection
    before: FinalModel
    """The paper's model."""
    after: FinalModel
    """The model with the effects, as it was judged by what was held out."""
    effects: tuple[FoundEffect, ...]
    completed: Identification
    """The identification, with the model that has the effects in the paper's model's place, and the final values."""
    errors: Mapping[Stage, ErrorsByRole]
    """Of the model at each stage."""
    unexplained: Unexplained
    in_doubt: tuple[InDoubt, ...]
    """Effects that the motion neither shows nor excludes, the most likely first."""
    whole: WholeSwings | None
    """The final values and what belongs to them, given all that was measured; None where they were not found."""
    withdrawn: Withdrawn | None
    """Effects that were found and did not carry over to what was held out; None where none were."""
    failure: str
    """Why no parameter means anything, in words; empty where the fit did not fail."""
    failures: tuple[str, ...]
    """What could not be computed, in words."""
    longer: LongerWindows | None
    """Windows over which the motion could not be followed, before these."""

    @property
    def covariance(self) -> Array:
        """(unknowns, unknowns) covariance of the values of the model with the effects, those in doubt accounted for."""
        return self.completed.covariance

    @property
    def physical(self) -> PhysicalValues:
        """Physical values of the model with the effects."""
        return self.completed.physical


def trace(
    found: Identification,
    say: Callable[[str], None] = lambda line: None,
    stop: Callable[[], bool] = lambda: False,
    trying: Callable[[str], None] = lambda line: None,
    expected: Sequence[ExpectedEffect] = (),
    longer: LongerWindows | None = None,
) -> Trace:
    """Trace the residual of an identification to effects that the paper's model lacks.

    Args:
        found: the paper's model, identified.
        say: called with a line of text after each step.
        stop: asked repeatedly; true ends the tracing with the effects found so far.
        trying: called with what is tried next.
        expected: effects found on the rig before, which are tried first.
        longer: windows over which the motion could not be followed, and what they showed.

    Where the model does not follow the motion, no effects are tried, and `failure` says so.
    """
    data = found.data
    selection, failure = select_effects(found, say, stop, trying, expected, longer)
    # Held-out motion judges from here on, when everything is decided.
    before, after = _final_models(selection.before.fit, selection.after.fit, data)
    withdrawn = None
    if after is not before and is_worse(after.holdout.rmse(), before.holdout.rmse()):
        withdrawn = Withdrawn(tuple(active.effect.key for active in after.model.effects), after.holdout.rmse())
        selection, after = selection.withdrawn(), before
    selection = confirmed(selection, before, after)
    without = [_holdout_error(after, attempt.fit) for attempt in selection.without]
    errors = _errors(found, selection, before, after)
    in_doubt, not_computed = ((), ()) if failure else _in_doubt(selection.after.fit)
    # It has judged: from now on it tells of the values, too.
    whole, not_whole = (None, ()) if failure else final_values(after, data, say)
    fit = with_values(after.fit, whole.values) if whole else after.fit
    completed = _completed(found, fit)
    if whole or in_doubt:
        spread = whole.covariance if whole else completed.covariance
        completed = completed.with_covariance(spread + added_covariance(in_doubt))
    left, not_described = _left(after, completed)
    return Trace(
        selection=selection,
        before=before,
        after=after,
        effects=found_effects(selection, after, fit, without, completed.covariance, completed.inertia),
        completed=completed,
        errors=errors,
        unexplained=left,
        in_doubt=in_doubt,
        whole=whole,
        withdrawn=withdrawn,
        failure=failure,
        failures=(*selection.failures, *completed.failures, *not_computed, *not_whole, *not_described),
        longer=longer,
    )


def is_worse(error: float, other: float) -> bool:
    """Return whether an error of held-out motion is larger than another one beyond chance, or not a number."""
    return not error <= _WORSE * other


def select_effects(
    found: Identification,
    say: Callable[[str], None] = lambda line: None,
    stop: Callable[[], bool] = lambda: False,
    trying: Callable[[str], None] = lambda line: None,
    expected: Sequence[ExpectedEffect] = (),
    longer: LongerWindows | None = None,
) -> tuple[Selection, str]:
    """Return the selection of effects, and why there is none, where the fit failed; arguments are those of `trace`."""
    data, failure = found.data, found.failure
    as_before = None
    if longer:
        before = attempt_of(found.fit, data.folds)
        progress = Progress(before, data.noise_level, say, stop, data.scales.encoder_steps, trying)
        as_before = fitted_over_shorter(longer.selection, progress)
    if not failure:
        try:
            selected = stepwise_selection(
                found.fit,
                data.folds,
                data.noise_level,
                say,
                stop,
                found.balances,
                data.scales.encoder_steps,
                found.options.named_effects_only,
                trying,
                expected,
                found.enough,
            )
        except FitFailedError as error:
            failure = str(error)
        else:
            return preferred(as_before, selected), ""
    return (as_before, "") if as_before else (Selection.nothing(attempt_of(found.fit, data.folds)), failure)


def _final_models(before: Fit, after: Fit, data: Data) -> tuple[FinalModel, FinalModel]:
    """Return the paper's model and the one with the effects; initial states of either are fitted from the other's.

    The paper's model comes first. Where it cannot follow the motion that is held out, the other one may lead there.

    Raises:
        IdentificationError, LinAlgError: neither can be evaluated.
    """
    try:
        first = FinalModel.of(before, data)
    except (IdentificationError, np.linalg.LinAlgError):
        if after is before:
            raise
        last = FinalModel.of(after, data)
        return last.like_this(before), last
    return first, first if after is before else first.like_this(after)


def _left(after: FinalModel, completed: Identification) -> tuple[Unexplained, tuple[str, ...]]:
    """Return what the model with the effects does not explain, and why that could not be computed."""
    data = completed.data
    try:
        return unexplained(after, data.noise, data.names, completed.inertia.value, completed.covariance), ()
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return Unexplained.not_examined(after, data.noise), (f"what remains: {error}",)


def _holdout_error(like: FinalModel, fit: Fit) -> float:
    """Return the error of another model over what was held out [rad]; not a number where it cannot be computed."""
    try:
        return like.like_this(fit).holdout.rmse()
    except (IdentificationError, np.linalg.LinAlgError):
        return float("nan")


def _errors(
    found: Identification, selection: Selection, before: FinalModel, after: FinalModel
) -> Mapping[Stage, ErrorsByRole]:
    data, model, prior = found.data, found.fit.model, found.options.prior

    def of_values(physical: Array) -> ErrorsByRole:
        inertia = float(inertia_about_cart(physical, prior.length))
        values = model.initial_values(groups_of(physical, prior.length), inertia)
        return evaluate(model, values, data, found.enough)

    def of(attempt: Attempt, final: FinalModel) -> ErrorsByRole:
        return ErrorsByRole(*(errors_of(fit, data.trials) for fit in (attempt.fit, attempt.validation, final.holdout)))

    return {
        "nominal": of_values(prior.centre),
        "search": of_values(found.estimate.search.best),
        "refined": of(selection.before, before),
        "effects": of(selection.after, after),
    }


def _completed(found: Identification, fit: Fit) -> Identification:
    """Return an identification with another fit and its diagnosis."""
    if fit is found.fit:
        return found
    estimate = replace(found.estimate, fit=fit)
    return Identification.of(found.options, found.data, found.balances, found.length, estimate)


def _in_doubt(fit: Fit) -> tuple[tuple[InDoubt, ...], tuple[str, ...]]:
    """Return the effects that the motion neither shows nor excludes, and why they could not be computed."""
    try:
        return effects_in_doubt(fit), ()
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return (), (f"the effects that the motion neither shows nor excludes: {error}",)
