# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The contents of `report.json`."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from datetime import datetime, timezone

import numpy as np
from scipy.special import expit

from cdp_ident.arrays import Array
from cdp_ident.diagnosis.identifiability import identifiability
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.diagnosis.new_trial import NewTrialCheck
from cdp_ident.diagnosis.prediction import plan_of, predicted
from cdp_ident.diagnosis.warnings import FitWarning, find_warnings, outlier_warnings
from cdp_ident.diagnosis.whiteness import Whiteness
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.physical import is_determined
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.report.knowledge import compared
from cdp_ident.report.next_trial import next_trial_section
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.provenance import versions
from cdp_ident.report.schema import REPORT, SCHEMA, Also, Section, filled
from cdp_ident.report.verdict import effect_in_words, quantity, verdict
from cdp_ident.tracing.found_effects import FoundEffect
from cdp_ident.tracing.odds import log10_odds, unlikelihood
from cdp_ident.tracing.trace import Trace


def report(
    outcome: Outcome, new_trials: Sequence[NewTrialCheck] = (), ends: Callable[[], bool] = lambda: False
) -> Section:
    """Return everything there is to report; plain values, to be written as JSON, as `schema.py` states it.

    Texts from outside, such as the names of bags, are fit to be shown.

    Args:
        outcome: what was found.
        new_trials: how trials that came later fitted before they were seen, in the order in which they came.
        ends: asked repeatedly; true ends what takes long, the search for the trial to record next.
    """
    job, trace = outcome.loaded.job, outcome.trace
    found, completed = outcome.identification, trace.completed
    # Without an effect it is one model, whose values are the final ones.
    same_model = completed.fit.model.names == found.fit.model.names
    paper = completed if same_model else replace(found, fit=trace.before.fit)
    failures = list(trace.failures)
    next_trial = next_trial_section(outcome, failures.append, ends)
    # Over what was held out both models know the zeros of all encoders; without an effect they are one.
    white = Whiteness.of(trace.before.holdout)
    white_after = white if trace.after is trace.before else Whiteness.of(trace.after.holdout)
    section = {
        "schema": SCHEMA,
        "trials": _trials(outcome),
        "noise_rad": found.data.noise,
        "search": _search(outcome),
        "stages": {stage: of for stage, of in trace.errors.items() if stage != "effects"},
        "before": _fit(paper) | {"error": trace.errors["refined"]},
        "refinement": Also(found.whole, {"windows": (len(found.data.fit), len(found.data.holdout))}),
        "effects": [_effect(outcome, effect) for effect in trace.effects],
        "after": _fit(completed) | {"error": trace.errors["effects"]},
        "unexplained": trace.unexplained,
        "verdict": verdict(trace),
        "prediction": _prediction(outcome),
        "residuals": (white.interval, white, white_after),
        "next_trial": next_trial,
        "selection": _selection(trace),
        "values_with_less_torque": trace.after.less_torque,
        "whole_swings": trace.whole and _whole_swings(trace.whole, completed.inertia.value),
        "repeatability": _repeatability(completed),
        "own_effects": job.own_effects,
        "expected": compared(job.expected, trace.effects) if job.expected else [],
        "new_trials": list(new_trials),
        "identifiability": identifiability(completed),
        "in_doubt": [(doubt.active.key, doubt.weight, doubt.change[: len(GROUPS)]) for doubt in trace.in_doubt],
        "warnings": list(_warnings(outcome, new_trials, failures)),
        "run": {
            "written_at": datetime.now(timezone.utc).isoformat(timespec="seconds"),
            "seconds": outcome.seconds,
            "versions": versions(),
            "options": job.settings.values(),
            "bag_sha256": {str(bag): files for bag, files in outcome.loaded.checksums.items()},
        },
    }
    return dict(filled(REPORT, section))


def _trials(outcome: Outcome) -> list[Also]:
    job = outcome.loaded.job
    bags = [*((bag, "fit") for bag in job.bags), *((bag, "holdout") for bag in job.holdout)]
    return [
        Also(trial, {"bag": str(bag), "role": role, "samples": len(trial.time), "warnings": trial.notes})
        for (bag, role), trial in zip(bags, outcome.loaded.trials, strict=True)
    ]


def _search(outcome: Outcome) -> Also:
    options, search = outcome.identification.options, outcome.identification.search
    also = {
        "method": options.method or "iga",
        "cut_short": options.method is None,
        "seed": options.seed,
        "population": options.search.population,
        "generations": len(search.history) - 1,
        "sse": search.error,
        "seconds": outcome.search_seconds,
    }
    return Also(search, also)


def _fit(found: Identification) -> Section:
    """Return what a fitted model is: physical values, base parameters, and how sure they are."""
    model, values, physical, inertia = found.fit.model, found.fit.values, found.physical, found.inertia
    std = np.sqrt(np.diag(found.covariance))
    numbers = zip(PARAMETERS, physical.values, physical.std, physical.determined, strict=True)
    section = {parameter.symbol: (value, of, parameter.unit, sure) for parameter, value, of, sure in numbers}
    for constant, value in zip(CONSTANTS, model.constants(values), strict=True):
        deviation = std[model.names.index(constant.symbol)] if constant.symbol in model.names else 0.0
        section[constant.symbol] = _estimate(constant.unit, value, deviation)
    determined = inertia.shown and is_determined(inertia.value, inertia.std)
    section[INERTIA.symbol] = inertia.value, inertia.std, INERTIA.unit, determined
    groups = zip(GROUPS, values, std, strict=False)
    errors = zip(model.weight_errors, values[model.of_weights], std[model.of_weights], strict=True)
    return {
        "physical": section,
        "physical_possible": physical.possible,
        "outer_rod_length_m": model.mechanism.outer_length,
        "groups": [_estimate(group.unit, value, deviation) for group, value, deviation in groups],
        "weight_errors": [(*error, value, deviation) for error, value, deviation in errors],
        "correlation": _correlation(model, found.covariance),
    }


def _estimate(unit: str, value: float, std: float) -> tuple[float, float, str, bool]:
    return value, std, unit, is_determined(value, std)


def _correlation(model: MotionModel, covariance: Array) -> Section:
    """Return how the errors of the estimates go together; not a number for one that the trials do not show.

    The coefficients of curves are not among them.
    """
    shown = ~model.of_curves
    covariance = covariance[np.ix_(shown, shown)]
    std = np.sqrt(np.diag(covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix = covariance / np.outer(std, std)
    return {"names": np.array(model.names)[shown].tolist(), "matrix": matrix}


def _prediction(outcome: Outcome) -> Also | None:
    """Return how the error of predictions grows, before and after; None where the trials are too short for any."""
    plan, trace = plan_of(outcome.identification.data), outcome.trace
    before = predicted(trace.before.holdout, plan)
    after = before if trace.after is trace.before else predicted(trace.after.holdout, plan)
    if before is None or after is None:
        return None
    also = {"starts": len(plan.starts), "told_s": plan.fitted_span, "time_s": after.time}
    return Also(plan, {**also, "before": before, "after": after})


def _effect(outcome: Outcome, found: FoundEffect) -> Also:
    """Return one of the effects that were found."""
    trial = found.active.trial
    effect = {
        "trial": None if trial is None else outcome.identification.data.trials[trial].name,
        "summary": effect_in_words(found),
        "parameters": {parameter.description.name: quantity(parameter) for parameter in found.parameters},
        "curve": found.curve,
        "evidence": found,
        "certainty": found.certainty,
        "also_possible": found.also_possible,
    }
    return Also(found.active.effect, effect)


def _selection(traced: Trace) -> Section | Also:
    """Return how the effects were selected, and what the others would do for the model that has them."""
    selection = traced.selection
    if selection is None:
        return {"interrupted": False, "looked_in_s": 0.0, "steps": [], "candidates": []}
    recorded = selection.after.recorded
    scores = [(s.active.key, log10_odds(s.misfit + unlikelihood(s.active, recorded))) for s in selection.scores]
    best_first = sorted(scores, key=lambda pair: -pair[1])
    return Also(selection, {"candidates": [(key, odds, expit(math.log(10.0) * odds)) for key, odds in best_first]})


def _whole_swings(found: WholeSwings, inertia: float) -> Also:
    of = found.noise
    noise = {"noise_rad": of.encoders, "noise_memory": of.memory, "time_noise_s": of.time}
    noise["absolute_angles"] = of.absolute
    return Also(found, {**noise, "missing_torque": inertia * found.torque, "swings": len(found.states)})


def _repeatability(found: Identification) -> Also | None:
    compared = found.repeatability
    if compared is None:
        return None
    groups = np.dstack([compared.values, compared.std])[:, : len(GROUPS)]
    return Also(compared, {"trials": list(zip(compared.trials, groups, strict=True))})


def _warnings(outcome: Outcome, new_trials: Sequence[NewTrialCheck], failures: Sequence[str]) -> Iterator[FitWarning]:
    trace, data = outcome.trace, outcome.identification.data
    yield from filter(None, (check.warning() for check in new_trials))
    if trace.failure:
        yield FitWarning("fit_failed", (), trace.failure)
    if longer := trace.longer:
        yield FitWarning(
            "not_followed",
            (),
            f"the motion is followed for half a swing only: over windows of {longer.duration:.3g} s, the best model "
            f"left {1e3 * longer.error:.3g} mrad of held-out motion, {longer.error / data.noise_level:.0f} times the "
            f"noise. So the errors here are over windows of {data.window:.2g} s; simulations that go on for longer are "
            "off by more",
        )
    yield from outlier_warnings(outcome.loaded.trials)
    yield from find_warnings(trace.completed)
    if failures:
        yield FitWarning("not_computed", (), f"what could not be computed is left out: {'; '.join(failures)}")
