# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From an identification to the effects that explain its residual, in physical units."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.diagnosis.evaluation import ErrorsByRole, errors_by_role, evaluate, refuse_a_failed_fit
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.errors import FitFailedError, IdentificationError
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.physical import PhysicalValues
from cdp_ident.likelihood.whole_swing import LARGER, WholeSwings
from cdp_ident.model.parameters import groups_of, inertia_about_cart
from cdp_ident.tracing.carry_over import Withdrawn, what_carries_over
from cdp_ident.tracing.certainty import shown_by, where_more_remains
from cdp_ident.tracing.final_model import FinalModel, final_values
from cdp_ident.tracing.found_effects import FoundEffect, found_effects
from cdp_ident.tracing.in_doubt import InDoubt, added_covariance, effects_in_doubt
from cdp_ident.tracing.select_effects import ExpectedEffect, select_effects
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.unexplained import Unexplained, unexplained

Stage = Literal["nominal", "search", "refined", "effects"]

_AT_LIMIT = 0.999
"""An encoder's scale with this share of the largest one would be larger still."""


@dataclass(frozen=True)
class LongerWindows:
    """Windows over which the motion could not be followed."""

    duration: float
    """[s]"""
    error: float
    """Over held-out motion [rad]."""


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
    noise_level: float
    """Root mean square of the encoders' noise [rad], with what lasts longer than from one sample to the next."""
    unexplained: Unexplained
    in_doubt: tuple[InDoubt, ...]
    """Effects that the motion neither shows nor excludes, the most likely first."""
    whole: WholeSwings | None
    """The most likely values given whole swings, all that was measured; None where they were not found."""
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
) -> Trace:
    """Trace the residual of an identification to effects that the paper's model lacks.

    Args:
        found: the paper's model, identified.
        say: called with a line of text after each step.
        stop: asked repeatedly; true ends the tracing with the effects found so far.
        trying: called with what is tried next.
        expected: effects found on the rig before, which are tried first.

    Where the model does not follow the motion, no effects are reported, and `failure` says so.
    """
    selection, failures = None, list[str]()
    if not found.failure:
        try:
            selection = select_effects(found, say, stop, trying, expected)
            failures += selection.failures
        except (IdentificationError, np.linalg.LinAlgError) as error:
            failures.append(f"effects were not looked for: {error}")
    return judged(found, selection, failures, say)


def judged(
    found: Identification,
    selection: Selection | None,
    failures: Sequence[str],
    say: Callable[[str], None],
    longer: LongerWindows | None = None,
) -> Trace:
    """Return what an identification is traced to, once held-out motion has judged the effects that were selected.

    Args:
        found: the paper's model, identified.
        selection: the effects; None where none were looked for.
        failures: what could not be computed until now, in words.
        say: called with a line of text.
        longer: windows over which the motion could not be followed.

    Raises:
        IdentificationError, LinAlgError: no model can be evaluated.
    """
    data, failure, searched = found.data, found.failure, selection
    without: Sequence[float] = ()
    withdrawn = None
    before = FinalModel.of(found.whole, data, found.fit)
    after = FinalModel.of(selection.after, data) if selection and selection.after is not found.whole else before
    try:
        refuse_a_failed_fit([after.fit, after.holdout], data.noise_level)
    except FitFailedError as error:
        failure = failure or str(error)
    failure = failure or (_wrong_counts(selection.after) if selection else "")
    if failure:
        selection, after = None, before
    if selection:
        try:
            known = len(selection.failures)
            after, selection, without, withdrawn = what_carries_over(before, after, selection, found)
            failures = [*failures, *selection.failures[known:]]
        except (IdentificationError, np.linalg.LinAlgError) as error:
            failures = [*failures, f"whether each effect carries over: {error}"]
            without = [float("nan")] * len(selection.without)
    errors = _errors(found, before, after)
    in_doubt = effects_in_doubt(selection.scores) if selection else ()
    chosen = selection.after if selection else found.whole
    final, completed = None, replace(found, fit=before.fit)
    if selection:
        # It has judged: from now on it tells of the values, too.
        final = final_values(after, chosen, data, say)
        failures = [*failures, *final.failures]
        selection = shown_by(selection, final.values, final.covariance)
        try:
            completed = _completed(found, final.whole or chosen, after, final.values, final.covariance)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            failures = [*failures, f"the final values, so those are given that were judged: {error}"]
            completed = _completed(found, chosen, after, after.fit.values, chosen.covariance)
    if in_doubt:
        completed = completed.with_covariance(completed.covariance + added_covariance(in_doubt))
    whole = final.whole if final else None
    noise = whole.noise_level(data.noise) if whole else data.noise_level
    remains = unexplained(after, whole, data.noise, completed.inertia)
    effects: tuple[FoundEffect, ...] = ()
    if selection:
        alike = not any(active.is_difference for active in chosen.model.effects)
        held_out = after.holdout.rmse()
        may_be_more = whole is None or bool(np.any(whole.leaves_more))
        if (remains.significant and alike) or (may_be_more and held_out > LARGER * noise):
            selection = where_more_remains(selection, held_out, without, noise)
        effects = found_effects(selection, after, completed.fit, without, completed.covariance, completed.inertia)
    return Trace(
        selection=selection,
        searched=searched,
        before=before,
        after=after,
        effects=effects,
        completed=completed,
        errors=errors,
        noise_level=noise,
        unexplained=remains,
        in_doubt=in_doubt,
        whole=whole,
        withdrawn=withdrawn,
        longer=longer,
        failure=failure,
        failures=(*failures, *completed.failures),
    )


def _wrong_counts(found: WholeSwings) -> str:
    """Say of which encoder the counts per turn are wrong by more than any effect; nothing where those of none are."""
    for index, active in enumerate(found.model.effects):
        if not active.effect.law.reading or active.effect.words != {"angle"} or len(active.fitted) > 1:
            continue
        (largest,), joint = [parameter.upper for parameter in active.fitted], active.effect.joint
        if np.all(np.abs(found.values[found.model.places(index)]) > _AT_LIMIT * largest):
            return (
                f"the fit failed: the {joint} joint's readings are more than {100.0 * largest:.0f} % off its "
                f"angle. Check the counts per turn (trial.{joint}_scale), and what the angles mean"
            )
    return ""


def _errors(found: Identification, before: FinalModel, after: FinalModel) -> Mapping[Stage, ErrorsByRole]:
    data, model, prior = found.data, found.fit.model, found.options.prior

    def of_values(physical: Array) -> ErrorsByRole:
        inertia = float(inertia_about_cart(physical, prior.length))
        values = model.initial_values(groups_of(physical, prior.length), inertia)
        return evaluate(model, values, data, found.enough)

    refined = errors_by_role(before.fit, before.holdout, data)
    return {
        "nominal": of_values(prior.centre),
        "search": of_values(found.search.best),
        "refined": refined,
        "effects": errors_by_role(after.fit, after.holdout, data) if after is not before else refined,
    }


def _completed(
    found: Identification, whole: WholeSwings, after: FinalModel, values: Array, covariance: Array
) -> Identification:
    """Return an identification with another model, its values and their covariance, and its diagnosis.

    Raises:
        IdentificationError, LinAlgError: no motion can be computed.
    """
    fit = fit_initial_states(after.model, values, after.fit.windows)
    return Identification.of(found.options, found.data, found.search, whole, fit, covariance)
