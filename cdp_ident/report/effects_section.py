"""What `report.json` says of the effects that were found, and of the steps of their selection."""

import math
from collections.abc import Iterator

from scipy.special import expit

from cdp_ident.model.parameters import GROUPS
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import Section
from cdp_ident.report.verdict import effect_in_words
from cdp_ident.tracing.odds import unlikelihood
from cdp_ident.tracing.selection import Selection
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
        "curve": found.curve,
        "evidence": {
            "log10_odds": found.log_odds,
            "probability": found.probability,
            "rmse_holdout_before_rad": found.holdout_without,
            "rmse_holdout_after_rad": found.holdout_with,
        },
        "certainty": found.certainty,
        "also_possible": found.also_possible,
    }


def in_doubt_section(traced: Trace) -> list[Section]:
    """Return the effects that the trials neither show nor exclude."""
    return [
        {
            "effect": effect.active.effect.key,
            "weight": effect.weight,
            "changes": {group.symbol: effect.change[index] for index, group in enumerate(GROUPS)},
        }
        for effect in traced.in_doubt
    ]


def selection_section(traced: Trace) -> Section:
    """Return how the effects were selected, and what the others would do for the model that has them."""
    selection = traced.selection
    if selection is None:
        return {"interrupted": False, "looked_in_s": 0.0, "steps": [], "candidates": []}
    return {
        "interrupted": selection.interrupted,
        "looked_in_s": selection.seconds,
        "steps": [
            {
                "action": step.action,
                "log10_odds": _log10_odds(step.misfit),
                "tried": [{"effects": tried.effects, "log10_odds": _log10_odds(tried.misfit)} for tried in step.tried],
            }
            for step in selection.steps
        ],
        "candidates": sorted(_candidates(selection), key=lambda candidate: -candidate["log10_odds"]),
    }


def _candidates(selection: Selection) -> Iterator[Section]:
    for score in selection.scores:
        log10_odds = _log10_odds(score.misfit + unlikelihood(score.active, selection.after.recorded))
        yield {
            "effect": score.active.effect.key,
            "log10_odds": log10_odds,
            "probability": float(expit(math.log(10.0) * log10_odds)),
        }


def _log10_odds(misfit: float) -> float:
    """Return the odds of a model whose misfit is by so much larger than another one's."""
    return -misfit / (2.0 * math.log(10.0))
