"""From an identification to the effects that explain its residual, in physical units."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.evaluation import ErrorsByRole, errors_of, evaluate
from cdp_ident.diagnosis.failure import refuse_a_failed_fit
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.errors import FitFailedError, IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.physical import PhysicalValues
from cdp_ident.fit.refinement import Fit, fit_initial_states_near
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.parameters import groups_of, inertia_about_cart
from cdp_ident.tracing.expected import ExpectedEffect
from cdp_ident.tracing.final_model import FinalModel, is_worse
from cdp_ident.tracing.final_values import at_values, final_values, over_windows
from cdp_ident.tracing.found_effects import FoundEffect, found_effects
from cdp_ident.tracing.in_doubt import InDoubt, added_covariance, effects_in_doubt
from cdp_ident.tracing.select_effects import select_effects, withdrawn_from
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.unexplained import Unexplained, unexplained

Array = npt.NDArray[np.float64]
Stage = Literal["nominal", "search", "refined", "effects"]


@dataclass(frozen=True)
class LongerWindows:
    """Windows over which the motion could not be followed."""

    duration: float
    """[s]"""
    error: float
    """Over held-out motion [rad]."""
    selection: Selection | None
    """The effects that were found."""


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

    selection: Selection | None
    """How the effects were found; None where none were looked for."""
    searched: Selection | None
    """The same before held-out motion has judged it."""
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
    """The most likely values given whole swings, all that was measured; None where they were not found."""
    by_windows: bool
    """Whether the final values are not these, but were fitted over windows."""
    withdrawn: Withdrawn | None
    """Effects that were found and did not carry over to what was held out; None where none were."""
    longer: LongerWindows | None
    """Windows over which the motion could not be followed; None where it is followed over the windows of the fit."""
    failure: str
    """Why no parameter means anything, in words; empty where the fit did not fail."""
    failures: tuple[str, ...]
    """What could not be computed, in words."""

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
        longer: windows over which the motion could not be followed, with the effects that were found.

    Where the model does not follow the motion, no effects are tried, and `failure` says so.
    """
    data, failure, failures = found.data, found.failure, list[str]()
    selection = longer.selection if longer else None
    if not failure and not longer:
        try:
            selection = select_effects(found, say, stop, trying, expected)
            failures += selection.failures
        except (IdentificationError, np.linalg.LinAlgError) as error:
            failures.append(f"effects were not looked for: {error}")
    # Held-out motion judges from here on, when everything is decided.
    before, after, by_windows = _final_models(found.fit, selection.after if selection else None, data)
    try:
        refuse_a_failed_fit([after.fit, after.holdout], data.noise_level)
    except FitFailedError as error:
        failure = failure or str(error)
    if failure:
        selection, after = None, before
    searched, withdrawn = selection, None
    if selection and is_worse(after.holdout.rmse(), before.holdout.rmse()):
        keys = tuple(active.effect.key for active in selection.after.model.effects)
        withdrawn, after = Withdrawn(keys, after.holdout.rmse()), before
        selection = withdrawn_from(selection, found.options.named_effects_only)
    others = selection.without if selection else ()
    without = [_holdout_error(after, found.fit, other, by_windows) for other in others]
    errors = _errors(found, before, after)
    in_doubt = effects_in_doubt(selection.scores) if selection else ()
    # It has judged: from now on it tells of the values, too.
    final = final_values(after, selection.after, data, by_windows, say) if selection else None
    whole = final.whole if final else None
    completed = None
    if final:
        try:
            completed = _completed(found, at_values(after.model, final.values, after.fit.windows))
        except (IdentificationError, np.linalg.LinAlgError) as error:
            failures += [*final.failures, f"the final values, so those are given that were judged: {error}"]
            final = None
    completed = completed or _completed(found, after.fit)
    if final or in_doubt:
        spread = final.covariance if final else completed.covariance
        completed = completed.with_covariance(spread + added_covariance(in_doubt))
    return Trace(
        selection=selection,
        searched=searched,
        before=before,
        after=after,
        effects=found_effects(selection, after, completed.fit, without, completed.covariance, completed.inertia)
        if selection
        else (),
        completed=completed,
        errors=errors,
        unexplained=unexplained(after, whole, data.noise, completed.inertia),
        in_doubt=in_doubt,
        whole=whole,
        by_windows=final.by_windows if final else True,
        withdrawn=withdrawn,
        longer=longer,
        failure=failure,
        failures=(*failures, *completed.failures, *(final.failures if final else ())),
    )


def _final_models(fit: Fit, chosen: WholeSwings | None, data: Data) -> tuple[FinalModel, FinalModel, bool]:
    """Return the paper's model and the one with the effects; initial states of either are fitted from the other's.

    The paper's model comes first. Where it cannot follow the motion that is held out, the other one may lead there.
    Where torques are missing, held-out motion also judges which values predict better, those fitted over windows or
    those of whole swings; the third value is whether the former do.

    Raises:
        IdentificationError, LinAlgError: neither can be evaluated.
    """
    after = fit if chosen is None else _fitted(fit, chosen, by_windows=True)
    try:
        first = FinalModel.of(fit, data)
        last = first if after is fit else first.like_this(after)
    except (IdentificationError, np.linalg.LinAlgError):
        if after is fit:
            raise
        last = FinalModel.of(after, data)
        first = last.like_this(fit)
    if chosen is None or not np.any(chosen.is_missing):
        return first, last, False
    whole = last.like_this(_fitted(fit, chosen, by_windows=False))
    by_windows = last.holdout.rmse() < whole.holdout.rmse()
    return first, last if by_windows else whole, by_windows


def _fitted(fit: Fit, found: WholeSwings, by_windows: bool) -> Fit:
    """Return a model over the windows of a fit, with values fitted to these or to whole swings."""
    if not found.model.effects:
        return fit
    if by_windows:
        return over_windows(found.model, found.values, fit.windows)
    return at_values(found.model, found.values, fit.windows)


def _holdout_error(like: FinalModel, fit: Fit, other: WholeSwings | None, by_windows: bool) -> float:
    """Return the error of another model, fitted as the final one was, over what was held out [rad].

    Not a number where it cannot be computed.
    """
    if other is None:
        return float("nan")
    try:
        values = _fitted(fit, other, by_windows).values
        return fit_initial_states_near(other.model, values, like.holdout.windows, np.inf).rmse()
    except (IdentificationError, np.linalg.LinAlgError):
        return float("nan")


def _errors(found: Identification, before: FinalModel, after: FinalModel) -> Mapping[Stage, ErrorsByRole]:
    data, model, prior = found.data, found.fit.model, found.options.prior

    def of_values(physical: Array) -> ErrorsByRole:
        inertia = float(inertia_about_cart(physical, prior.length))
        values = model.initial_values(groups_of(physical, prior.length), inertia)
        return evaluate(model, values, data, found.enough)

    def of(final: FinalModel) -> ErrorsByRole:
        return ErrorsByRole(*(errors_of(fit, data.trials) for fit in (final.fit, final.holdout)))

    return {
        "nominal": of_values(prior.centre),
        "search": of_values(found.estimate.search.best),
        "refined": of(before),
        "effects": of(after),
    }


def _completed(found: Identification, fit: Fit) -> Identification:
    """Return an identification with another fit and its diagnosis."""
    if fit is found.fit:
        return found
    estimate = replace(found.estimate, fit=fit)
    return Identification.of(found.options, found.data, found.balances, found.length, estimate)
