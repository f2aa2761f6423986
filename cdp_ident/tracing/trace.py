"""From an identification to the effects that explain its residual, in physical units."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.evaluation import Errors, evaluate
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.fit.motion_model import ActiveEffect
from cdp_ident.fit.physical import PhysicalValues
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.effects.effect import EffectParameter
from cdp_ident.model.parameters import inertia_about_cart
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.stepwise import stepwise_selection
from cdp_ident.tracing.unexplained import Unexplained, unexplained

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class FoundParameter:
    """A parameter of an effect, in its physical unit."""

    description: EffectParameter
    value: float
    std: float
    """0 for one that is a part of the effect's definition."""


@dataclass(frozen=True)
class FoundEffect:
    """An effect that was added to the model."""

    active: ActiveEffect
    parameters: tuple[FoundParameter, ...]
    holdout_without: float
    """Error over the windows kept out of the fit, of the model without this effect [rad]."""
    holdout_with: float
    """The same of the model with all effects [rad]."""
    delta_bic: float
    """Bayes's information criterion of the model with all effects less that of the one without this effect."""
    certainty: Literal["named", "probable", "acts_like"]
    """How sure its name is; that it predicts is judged apart from that."""
    also_possible: tuple[str, ...]
    """Effects that the data cannot tell from this one."""


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
    found: Identification, told: Callable[[str], None] = lambda line: None, stop: Callable[[], bool] = lambda: False
) -> Trace:
    """Trace the residual of an identification to effects that the paper's model lacks.

    Args:
        found: the paper's model, identified.
        told: called with a line for people after each step.
        stop: asked now and then; true ends the tracing with the effects found so far.

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
    )
    completed = _completed(found, selection.after.fit)
    after, physical = selection.after, completed.physical
    values, spread = after.fit.values, completed.covariance
    length, _ = after.model.constants(values)
    inertia = float(inertia_about_cart(physical.values, length))
    effects = tuple(
        _found(selection, index, spread, inertia, physical.inertia_relative_std)
        for index in range(len(after.model.effects))
    )
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


def _found(selection: Selection, index: int, spread: Array, inertia: float, inertia_std: float) -> FoundEffect:
    after = selection.after
    active, place = after.model.effects[index], after.model.places(index)
    fitted = iter(zip(after.fit.values[place], np.sqrt(np.diag(spread)[place]), strict=True))
    parameters = []
    for parameter in active.effect.parameters:
        value, std = (parameter.typical, 0.0) if parameter.fixed else next(fitted)
        scale = parameter.scale(inertia)
        # A torque is seen over A22 only; in N m it is as uncertain as the masses besides.
        scale_std = abs(parameter.inertia_power * value) * inertia_std
        parameters.append(FoundParameter(parameter, float(value) * scale, float(np.hypot(std, scale_std)) * scale))
    return FoundEffect(
        active=active,
        parameters=tuple(parameters),
        holdout_without=selection.holdout_without[index],
        holdout_with=after.holdout.rmse(),
        delta_bic=selection.evidence[index].bic,
        certainty=selection.certainty[index],
        also_possible=selection.also_possible[index],
    )
