"""The contents of `report.json`."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime, timezone

import numpy as np

from cdp_ident.diagnosis.identifiability import identifiability
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.diagnosis.new_trial import NewTrialCheck
from cdp_ident.diagnosis.warnings import FitWarning, find_warnings, outlier_warnings
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.parameters import GROUPS
from cdp_ident.report.effects_section import compared, effect_section, in_doubt_section, selection_section
from cdp_ident.report.model_section import errors_section, fit_section, prediction_section, residuals_section
from cdp_ident.report.next_trial import next_trial_section
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.provenance import versions
from cdp_ident.report.schema import REPORT, SCHEMA, Section
from cdp_ident.report.schema_terms import Also, filled
from cdp_ident.report.verdict import verdict
from cdp_ident.trial.trial import Trial


def report(outcome: Outcome, new_trials: Sequence[NewTrialCheck] = ()) -> Section:
    """Return everything there is to report; plain values, to be written as JSON, as `schema.py` states it.

    Texts from outside, such as the names of bags, are fit to be shown.

    Args:
        outcome: what was found.
        new_trials: how trials that came later fitted before they were seen, in the order in which they came.
    """
    return dict(filled(REPORT, _report(outcome, new_trials)))


def _report(outcome: Outcome, new_trials: Sequence[NewTrialCheck]) -> Section:
    job, trace = outcome.loaded.job, outcome.trace
    found, completed = outcome.identification, trace.completed
    # Without an effect it is one model, whose values are the final ones.
    same_model = completed.fit.model.names == found.fit.model.names
    paper = completed if same_model else replace(found, fit=trace.before.fit)
    failures = list(trace.failures)
    next_trial = next_trial_section(outcome, failures.append)
    errors = {stage: errors_section(found.data, of) for stage, of in trace.errors.items()}
    return {
        "schema": SCHEMA,
        "trials": _trials(outcome),
        "noise_rad": found.data.noise,
        "search": _search(outcome),
        "stages": {stage: errors[stage] for stage in errors if stage != "effects"},
        "before": fit_section(paper) | {"error": errors["refined"]},
        "refinement": {
            "steps": found.whole.steps,
            "converged": found.whole.converged,
            "windows": (len(found.data.fit), len(found.data.holdout)),
        },
        "effects": [effect_section(outcome, effect) for effect in trace.effects],
        "after": fit_section(completed) | {"error": errors["effects"]},
        "unexplained": trace.unexplained,
        "verdict": verdict(trace),
        "prediction": prediction_section(outcome),
        "residuals": residuals_section(trace),
        "next_trial": next_trial,
        "selection": selection_section(trace),
        "values_with_less_torque": trace.after.less_torque,
        "whole_swings": trace.whole and _whole_swings(trace.whole, completed.inertia.value),
        "repeatability": _repeatability(completed),
        "own_effects": job.own_effects,
        "expected": compared(job.expected, trace.effects) if job.expected else [],
        "new_trials": list(new_trials),
        "identifiability": _identifiability(completed),
        "in_doubt": in_doubt_section(trace),
        "warnings": list(_warnings(outcome, new_trials, failures)),
        "run": {
            "written_at": datetime.now(timezone.utc).isoformat(timespec="seconds"),
            "seconds": outcome.seconds,
            "versions": versions(),
            "options": job.settings.values(),
            "bag_sha256": {str(bag): files for bag, files in outcome.loaded.checksums.items()},
        },
    }


def _trials(outcome: Outcome) -> list[Also]:
    job, fitted = outcome.loaded.job, len(outcome.loaded.fit)
    found = []
    for index, (bag, trial) in enumerate(zip((*job.bags, *job.holdout), _loaded(outcome), strict=True)):
        role = "fit" if index < fitted else "holdout"
        also = {"bag": str(bag), "role": role, "samples": len(trial.time), "warnings": trial.notes}
        found.append(Also(trial, also))
    return found


def _loaded(outcome: Outcome) -> tuple[Trial, ...]:
    """Return the trials as they were loaded, before any were averaged."""
    return *outcome.loaded.fit, *outcome.loaded.holdout


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


def _whole_swings(found: WholeSwings, inertia: float) -> Also:
    noise = {"noise_rad": found.noise.encoders, "noise_memory": found.noise.memory}
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
    if failures:
        yield FitWarning("not_computed", (), f"what could not be computed is left out: {'; '.join(failures)}")
    if longer := trace.longer:
        yield FitWarning(
            "not_followed",
            (),
            f"the motion is followed for half a swing only: over windows of {longer.duration:.3g} s, the best model "
            f"left {1e3 * longer.error:.3g} mrad of held-out motion, {longer.error / data.noise_level:.0f} times the "
            f"noise. So the errors here are over windows of {data.window:.2g} s; simulations that go on for longer are "
            "off by more",
        )
    yield from outlier_warnings(_loaded(outcome))
    yield from find_warnings(trace.completed)


def _identifiability(completed: Identification) -> Also:
    found = identifiability(completed)
    unseen, physical = ([tradeoff.changes for tradeoff in of] for of in (found.unobservable, found.tradeoffs))
    return Also(found, {"unseen_changes": unseen, "physical_changes_without_effect": physical})
