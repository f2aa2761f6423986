"""What `report.json` says of effects: those found, the steps of their selection, and those of an earlier report."""

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import expit

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.parameters import GROUPS
from cdp_ident.report.curves import Array
from cdp_ident.report.formatting import number
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import Section
from cdp_ident.report.schema_terms import Also
from cdp_ident.report.verdict import effect_in_words, quantity
from cdp_ident.tracing.expected import ExpectedEffect
from cdp_ident.tracing.found_effects import FoundEffect
from cdp_ident.tracing.odds import log10_odds, unlikelihood
from cdp_ident.tracing.trace import Trace

_NO_ESTIMATE = {"as_fitted": {"value": None, "std": None}}
"""Of a parameter that a report does not have."""


def effect_section(outcome: Outcome, found: FoundEffect) -> Also:
    """Return one of the effects that were found."""
    trial = found.active.trial
    evidence = {"rmse_holdout_before_rad": found.holdout_without, "rmse_holdout_after_rad": found.holdout_with}
    effect = {
        "trial": None if trial is None else outcome.identification.data.trials[trial].name,
        "summary": effect_in_words(found),
        "parameters": {parameter.description.name: quantity(parameter) for parameter in found.parameters},
        "curve": found.curve,
        "evidence": Also(found, evidence),
        "certainty": found.certainty,
        "also_possible": found.also_possible,
    }
    return Also(found.active.effect, effect)


def in_doubt_section(traced: Trace) -> list[tuple[str, float, Array]]:
    """Return the effects that the trials neither show nor exclude."""
    return [(doubt.active.effect.key, doubt.weight, doubt.change[: len(GROUPS)]) for doubt in traced.in_doubt]


def selection_section(traced: Trace) -> Section:
    """Return how the effects were selected, and what the others would do for the model that has them."""
    selection = traced.selection
    if selection is None:
        return {"interrupted": False, "looked_in_s": 0.0, "steps": [], "candidates": []}
    recorded = selection.after.recorded
    scores = [(s.active.effect.key, log10_odds(s.misfit + unlikelihood(s.active, recorded))) for s in selection.scores]
    return {
        "interrupted": selection.interrupted,
        "looked_in_s": selection.seconds,
        "steps": selection.steps,
        "candidates": [
            (effect, odds, float(expit(math.log(10.0) * odds)))
            for effect, odds in sorted(scores, key=lambda pair: -pair[1])
        ],
    }


def expected_effects(report: Section) -> tuple[ExpectedEffect, ...]:
    """Return the effects of a report that may be expected again.

    Effects of an instant are left out, and so are nonparametric torques, whose shapes belong to their trials.
    """
    sections = {(section["name"], section["joint"], section["variant"]): section for section in report["effects"]}
    found = []
    for effect in known_effects():
        section = sections.get((effect.name, effect.joint, effect.variant))
        if section is None or effect.at_an_instant or effect.curve is not None:
            continue
        fitted = [section["parameters"].get(p.name, _NO_ESTIMATE)["as_fitted"] for p in ActiveEffect(effect).fitted]
        values, std = (np.array([number(estimate[of]) for estimate in fitted]) for of in ("value", "std"))
        if np.all(np.isfinite(values)):
            found.append(ExpectedEffect(effect, values, std))
    return tuple(found)


def compared(expected: Sequence[ExpectedEffect], found: Sequence[FoundEffect]) -> list[Section]:
    """Return what became of each effect that was expected, and which effects are new."""
    new = {effect.active.effect.key: effect for effect in found}
    sections = []
    for before in expected:
        now = new.pop(before.effect.key, None)
        sections.append(_of(before.effect, "confirmed" if now else "withdrawn", _changes(before, now) if now else {}))
    return [*sections, *(_of(effect.active.effect, "new", {}) for effect in new.values())]


def _of(effect: Effect, state: str, parameters: Section) -> Section:
    identity = {"name": effect.name, "joint": effect.joint, "variant": effect.variant}
    return {**identity, "state": state, "parameters": parameters}


def _changes(before: ExpectedEffect, now: FoundEffect) -> Section:
    shown, changes = {parameter.description.name: parameter for parameter in now.parameters}, {}
    for parameter, value, std in zip(ActiveEffect(before.effect).fitted, before.values, before.std, strict=True):
        new = shown[parameter.name]
        change, spread = abs(new.shown - float(value)), float(np.hypot(std, new.shown_std))
        deviations = change / spread if spread > 0.0 else 0.0
        changes[parameter.name] = {"before": float(value), "now": new.shown, "deviations": deviations}
    return changes
