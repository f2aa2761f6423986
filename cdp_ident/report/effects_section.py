"""What `report.json` says of the effects that were found, and of the steps of their selection."""

from cdp_ident.model.parameters import GROUPS
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import Section
from cdp_ident.report.verdict import effect_in_words
from cdp_ident.tracing.found_effects import FoundCurve
from cdp_ident.tracing.trace import Trace


def effect_section(outcome: Outcome, index: int) -> Section:
    """Return one of the effects that were found."""
    found = outcome.trace.effects[index]
    effect, trial = found.active.effect, found.active.trial
    return {
        "name": effect.name,
        "joint": effect.joint,
        "variant": effect.variant,
        "trial": None if trial is None else outcome.identification.data.trials[trial].name,
        "description": effect.description,
        "summary": effect_in_words(found),
        "formula": effect.formula,
        "source": effect.source,
        "parameters": {
            parameter.description.name: {
                "value": parameter.value,
                "std": parameter.std,
                "unit": parameter.description.unit,
                "as_fitted": {"value": parameter.shown, "std": parameter.shown_std},
            }
            for parameter in found.parameters
        },
        "curve": None if found.curve is None else _curve(found.curve),
        "evidence": {
            "rmse_validation_before_rad": found.validation_without,
            "rmse_validation_after_rad": found.validation_with,
            "rmse_holdout_before_rad": found.holdout_without,
            "rmse_holdout_after_rad": found.holdout_with,
            "delta_bic": found.delta_bic,
        },
        "certainty": found.certainty,
        "also_possible": list(found.also_possible),
    }


def in_doubt_section(traced: Trace) -> list[Section]:
    """Return the effects that the trials neither show nor exclude."""
    return [
        {
            "effect": effect.active.effect.key,
            "weight": effect.weight,
            "changes": {group.symbol: float(effect.change[index]) for index, group in enumerate(GROUPS)},
        }
        for effect in traced.in_doubt
    ]


def _curve(found: FoundCurve) -> Section:
    return {
        "over": found.over,
        "at": found.at.tolist(),
        "torque": found.torque.tolist(),
        "std": found.std.tolist(),
        "coefficients": found.coefficients.tolist(),
        "coefficients_std": found.coefficients_std.tolist(),
        "likeness": found.likeness,
    }


def selection_section(traced: Trace) -> Section:
    """Return the steps by which the effects were selected."""
    selection = traced.selection
    return {
        "interrupted": selection.interrupted,
        "looked_in": selection.looked_in,
        "steps": [
            {
                "action": step.action,
                "rmse_fit_rad": step.rmse_fit,
                "rmse_validation_rad": step.rmse_validation,
                "tried": [
                    {
                        "effects": list(tried.effects),
                        "rmse_fit_rad": tried.rmse_fit,
                        "rmse_validation_rad": tried.rmse_validation,
                        "delta_bic": tried.delta_bic,
                    }
                    for tried in step.tried
                ],
            }
            for step in selection.steps
        ],
    }
