"""From an identification to the effects that explain its residual, in physical units."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.evaluation import Errors, evaluate
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.fit.physical import PhysicalValues
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.parameters import inertia_about_cart
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.found_effects import FoundEffect, found_effects
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.stepwise import stepwise_selection
from cdp_ident.tracing.unexplained import Unexplained, unexplained

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trace:
    """What an identification's residual was traced to."""

    ladder: Selection
    effects: tuple[FoundEffect, ...]
    completed: Identification
    """The identification, with the model that has the effects in the paper's model's place."""
    errors: tuple[Errors, Errors]
    """Errors of the model with the effects, over the fitted and over the held-out windows."""
    unexplained: Unexplained

    @property
    def after(self) -> Attempt:
        """The model with the effects."""
        return self.ladder.after

    @property
    def covariance(self) -> Array:
        """(unknowns, unknowns) covariance of the values of the model with the effects."""
        return self.completed.covariance

    @property
    def physical(self) -> PhysicalValues:
        """Physical values of the model with the effects."""
        return self.completed.physical


def trace(
    found: Identification,
    told: Callable[[str], None] = lambda line: None,
    stop: Callable[[], bool] = lambda: False,
    trying: Callable[[str], None] = lambda line: None,
) -> Trace:
    """Trace the residual of an identification to effects that the paper's model lacks.

    Args:
        found: the paper's model, identified.
        told: called with a line for people after each step.
        stop: asked now and then; true ends the tracing with the effects found so far.
        trying: called with what is tried next.

    Raises:
        FitFailedError: the model does not follow the motion; no effect is sought then.
    """
    selection = stepwise_selection(
        found.fit,
        found.data.holdout,
        float(np.sqrt(np.mean(found.data.noise**2))),
        told,
        stop,
        found.balances,
        found.data.scales.encoder_steps,
        found.options.named_effects_only,
        trying,
    )
    completed = _completed(found, selection.after.fit)
    after, physical = selection.after, completed.physical
    values, spread = after.fit.values, completed.covariance
    length, _ = after.model.constants(values)
    inertia = float(inertia_about_cart(physical.values, length))
    effects = found_effects(selection, spread, inertia, physical.inertia_relative_std)
    return Trace(
        ladder=selection,
        effects=effects,
        completed=completed,
        errors=(
            evaluate(after.model, values, found.data.fit, found.data.trials),
            evaluate(after.model, values, found.data.holdout, found.data.trials),
        ),
        unexplained=unexplained(selection, found.data.noise, found.data.names, inertia),
    )


def _completed(found: Identification, fit: Fit) -> Identification:
    """Return an identification with another fit, and all that follows from it."""
    if fit is found.fit:
        return found
    estimate = replace(found.estimate, fit=fit)
    return Identification.of(found.options, found.data, found.balances, found.length, estimate, found.errors)
