# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The effects of a model in physical units, and what curves look like."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.diagnosis.identification import Inertia
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.initial_states import Fit
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.curves import basis
from cdp_ident.model.effects.effect import JOINTS, Curve, EffectParameter
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.missing_torque import MissingTorque
from cdp_ident.tracing.odds import log10_odds
from cdp_ident.tracing.selection import Certainty, Selection

POINTS = 120
"""Points at which a curve is described, over the range that the motion covers."""
_LARGEST = EffectParameter("largest", "N m", -np.inf, np.inf, 0.0)
_AT = {
    "angle": EffectParameter("at", "rad", -np.pi, np.pi, 0.0),
    "speed": EffectParameter("at", "rad/s", 0.0, 0.0, 0.0),
}


@dataclass(frozen=True)
class FoundParameter:
    """A parameter of an effect, in its physical unit."""

    description: EffectParameter
    value: float
    std: float
    """0 for one that is a part of the effect's definition."""
    shown: float
    """The value as the motion shows it: a torque over A22."""
    shown_std: float


@dataclass(frozen=True)
class FoundCurve:
    """A nonparametric torque, in N m, over the range that the fitted motion covers."""

    over: str
    """What it depends on: the joint's angle or its speed."""
    at: Array
    """(n,) angles from hanging, in one turn [rad], or speeds [rad/s]."""
    torque: Array
    """(n,) there; of dry friction its size."""
    std: Array
    """(n,) standard deviation of the torque, that of A22 apart."""
    coefficients: Array
    """(count,) all of the curve's."""
    coefficients_std: Array
    """(count,)"""
    likeness: str
    """The known shape that it is similar to; empty where there is none."""


@dataclass(frozen=True)
class FoundEffect:
    """An effect that was added to the model."""

    active: ActiveEffect
    parameters: tuple[FoundParameter, ...]
    """Of a curve, its largest torque and where that is."""
    rmse_holdout_before: float
    """Error over what was held out, of the model without this effect [rad]."""
    rmse_holdout_after: float
    """The same of the model with all effects [rad]."""
    log10_odds: float
    """Logarithm (base 10) of how many times as probable the model with all effects is as the one without this effect,
    before any trial both being the same; not a number where the latter cannot be fitted."""
    probability: float
    """That the effect is there, among all models that were fitted."""
    certainty: Certainty
    """How sure its name is; whether it predicts is a separate question."""
    also_possible: tuple[str, ...]
    """Effects that the data do not distinguish from this one."""
    curve: FoundCurve | None = None
    """Of a nonparametric torque."""


def found_effects(
    selection: Selection,
    final: FinalModel,
    fit: Fit,
    rmse_holdout_before: Sequence[float],
    spread: Array,
    inertia: Inertia,
) -> tuple[FoundEffect, ...]:
    """Return the effects that a selection ended with.

    Args:
        selection: where it ended.
        final: its model with the effects, as it was judged.
        fit: the same with its final values.
        rmse_holdout_before: error without each of them over what was held out [rad].
        spread: (unknowns, unknowns) covariance of the fitted values.
        inertia: A22.
    """
    found = []
    for index, active in enumerate(final.model.effects):
        over = active.effect.curve
        curve = _curve(fit, MissingTorque.of(selection.after), index, over, spread, inertia.value) if over else None
        parameters = _summary(curve, inertia) if curve else _parameters(fit, index, spread, inertia)
        found.append(
            FoundEffect(
                active=active,
                parameters=parameters,
                rmse_holdout_before=rmse_holdout_before[index],
                rmse_holdout_after=final.holdout.rmse(),
                log10_odds=_log10_odds(selection.without[index], selection.after),
                probability=selection.probability[index],
                certainty=selection.certainty[index],
                also_possible=selection.also_possible[index],
                curve=curve,
            )
        )
    return tuple(found)


def _log10_odds(without: WholeSwings | None, found: WholeSwings) -> float:
    return float("nan") if without is None else log10_odds(found.misfit - without.misfit)


def _parameters(fit: Fit, index: int, spread: Array, inertia: Inertia) -> tuple[FoundParameter, ...]:
    place = fit.model.places(index)
    fitted = iter(zip(fit.values[place], np.sqrt(np.diag(spread)[place]), inertia.covariance[place], strict=True))
    found = []
    for parameter in fit.model.effects[index].effect.parameters:
        value, std, covariance = (parameter.typical, 0.0, 0.0) if parameter.fixed else next(fitted)
        found.append(_physical(parameter, value, std, covariance, inertia))
    return tuple(found)


def _physical(
    parameter: EffectParameter, value: float, std: float, covariance: float, inertia: Inertia
) -> FoundParameter:
    """Return a parameter in its physical unit, from its value in the fit and the covariance of that with ln A22."""
    scale = parameter.scale(inertia.value)
    # A torque is seen over A22 only; in N m it is as uncertain as A22 besides.
    by_inertia = parameter.inertia_power * value
    variance = std**2 + (by_inertia * inertia.relative_std) ** 2 + 2.0 * by_inertia * covariance
    physical_std = float(np.sqrt(np.maximum(variance, 0.0))) * scale
    return FoundParameter(parameter, float(value) * scale, physical_std, float(value), float(std))


def _curve(fit: Fit, motion: MissingTorque, index: int, over: Curve, spread: Array, inertia: float) -> FoundCurve:
    effect, place = fit.model.effects[index].effect, fit.model.places(index)
    covered = motion.over(over.over, JOINTS.index(effect.joint))
    at = np.linspace(covered.min(), covered.max(), POINTS)
    contributions = basis(over, at)
    coefficients, of_coefficients = fit.values[place], spread[place, place]
    torque = contributions @ coefficients
    variances = np.einsum("nk,kl,nl->n", contributions, of_coefficients, contributions)
    return FoundCurve(
        over=over.over,
        at=at,
        torque=inertia * torque,
        std=inertia * np.sqrt(np.maximum(variances, 0.0)),
        coefficients=inertia * coefficients,
        coefficients_std=inertia * np.sqrt(np.diag(of_coefficients)),
        likeness=likeness(over.over, effect.moves and effect.dry, at, torque),
    )


def _summary(curve: FoundCurve, inertia: Inertia) -> tuple[FoundParameter, ...]:
    """Return the largest torque of a curve, as far as it is sure, and where it is."""
    place = int(np.argmax(np.abs(curve.torque) - curve.std))
    largest, std = curve.torque[place] / inertia.value, curve.std[place] / inertia.value
    return (
        _physical(_LARGEST, largest, std, 0.0, inertia),
        _physical(_AT[curve.over], curve.at[place], 0.0, 0.0, inertia),
    )


_ALIKE, _BY_MORE = 0.8, 0.03
"""A cause is mentioned if its shape explains at least so much of a curve's mean square, and by so much more than one
that is the same everywhere."""
_PLACES = 41
"""Number of places where a rub is tried, over the range that the motion covers."""
_WIDTHS = np.geomspace(0.04, 0.6, 12)
"""How far to each side it may reach [rad]."""


def likeness(over: str, dry: bool, at: Array, torque: Array) -> str:
    """Return in words what could cause such a torque; empty where nothing is similar that the catalogue lacks.

    Args:
        over: what the torque depends on, the joint's angle or its speed.
        dry: whether it is the size of dry friction.
        at: (n,) angles from hanging [rad] or speeds [rad/s], evenly over the range that the motion covers.
        torque: (n,) there.
    """
    if over != "angle":
        return ""
    if not dry:
        return "an unbalance" if _explained(torque, np.sin(at), np.cos(at)) > _ALIKE else ""
    rubs = [
        (_explained(torque, (np.abs(at - place) <= half).astype(float)), float(place))
        for place in np.linspace(at[0], at[-1], _PLACES)
        for half in _WIDTHS
    ]
    share, place = max(rubs)
    least = max(_ALIKE, _explained(torque, np.ones_like(at)) + _BY_MORE)
    return f"a part of the turn that rubs at {place:.2g} rad" if share > least else ""


def _explained(torque: Array, *columns: Array) -> float:
    """Return the share of a torque's mean square that columns (n,) explain."""
    shapes = np.column_stack(columns)
    left = torque - shapes @ np.linalg.lstsq(shapes, torque, rcond=1e-10)[0]
    return 1.0 - float(left @ left) / max(float(torque @ torque), 1e-300)
