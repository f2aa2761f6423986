"""The contents of `report.json`."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from datetime import datetime, timezone
from typing import Any

import numpy as np

from cdp_ident.diagnosis.identifiability import identifiability
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.diagnosis.new_trial import NewTrialCheck
from cdp_ident.diagnosis.warnings import FitWarning, find_warnings, outlier_warnings
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.parameters import GROUPS, SYMBOLS
from cdp_ident.outside_text import shown
from cdp_ident.report.earlier import compared
from cdp_ident.report.effects_section import effect_section, in_doubt_section, selection_section
from cdp_ident.report.model_section import errors_section, fit_section
from cdp_ident.report.next_trial import next_trial_section
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.provenance import versions
from cdp_ident.report.schema import SCHEMA, Section
from cdp_ident.report.schema_terms import LONGEST_TEXT
from cdp_ident.report.validation import prediction_section, residuals_section
from cdp_ident.report.verdict import verdict
from cdp_ident.tracing.trace import Trace
from cdp_ident.trial.trial import Trial


def report(outcome: Outcome, new_trials: Sequence[NewTrialCheck] = ()) -> Section:
    """Return everything there is to report; plain values, to be written as JSON, as `schema.py` states it.

    Texts from outside, such as the names of bags, are fit to be shown.

    Args:
        outcome: what was found.
        new_trials: how trials that came later fitted before they were seen, in the order in which they came.
    """
    return dict(plain(_report(outcome, new_trials)))


def plain(content: Any) -> Any:
    """Return contents of a report as plain values, whose texts are all fit to be shown."""
    if isinstance(content, str):
        return shown(content, LONGEST_TEXT)
    if is_dataclass(content):
        content = {field.name: getattr(content, field.name) for field in fields(content)}
    if isinstance(content, Mapping):
        return {shown(key, LONGEST_TEXT): plain(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [plain(value) for value in content]
    return content.tolist() if isinstance(content, np.ndarray | np.generic) else content


def _report(outcome: Outcome, new_trials: Sequence[NewTrialCheck]) -> Section:
    found, completed = outcome.identification, outcome.trace.completed
    # Without an effect it is one model, whose values are the final ones.
    paper = (
        completed
        if completed.fit.model.names == found.fit.model.names
        else replace(found, fit=outcome.trace.before.fit)
    )
    unexplained = outcome.trace.unexplained
    failures, expected = list(outcome.trace.failures), outcome.loaded.job.expected
    next_trial = next_trial_section(outcome, failures.append)
    return {
        "schema": SCHEMA,
        "trials": _trials(outcome),
        "noise_rad": dict(zip(("theta1", "theta2"), found.data.noise, strict=True)),
        "search": _search(outcome),
        "stages": {
            stage: errors_section(found.data, errors)
            for stage, errors in outcome.trace.errors.items()
            if stage != "effects"
        },
        "before": fit_section(paper, outcome.trace.errors["refined"]),
        "refinement": {
            "steps": found.whole.steps,
            "converged": found.whole.converged,
            "windows": {"fit": len(found.data.fit), "holdout": len(found.data.holdout)},
        },
        "effects": [effect_section(outcome, index) for index in range(len(outcome.trace.effects))],
        "after": fit_section(completed, outcome.trace.errors["effects"]),
        "unexplained": {**vars(unexplained), "torque": dict(zip(JOINTS, unexplained.torque, strict=True))},
        "verdict": verdict(outcome.trace),
        "prediction": prediction_section(outcome),
        "residuals": residuals_section(outcome),
        "next_trial": next_trial,
        "selection": selection_section(outcome.trace),
        "values_with_less_torque": outcome.trace.after.less_torque,
        "whole_swings": _whole_swings(outcome.trace.whole, completed.inertia.value),
        "repeatability": _repeatability(completed),
        "own_effects": outcome.loaded.job.own_effects,
        "expected": compared(expected, outcome.trace.effects) if expected else [],
        "new_trials": [_new_trial(check) for check in new_trials],
        "identifiability": _identifiability(completed),
        "in_doubt": in_doubt_section(outcome.trace),
        "warnings": [
            *_doubts(new_trials),
            *_failures(outcome.trace, failures),
            *_not_followed(outcome),
            *outlier_warnings(_loaded(outcome)),
            *find_warnings(completed),
        ],
        "run": _run(outcome),
    }


def _trials(outcome: Outcome) -> list[Section]:
    loaded = outcome.loaded
    bags = (*loaded.job.bags, *loaded.job.holdout)
    return [
        {
            "bag": str(bag),
            "name": trial.name,
            "role": "fit" if index < len(loaded.fit) else "holdout",
            "samples": len(trial.time),
            "start_s": trial.start,
            "duration_s": trial.duration,
            "clock": trial.clock and trial.clock._asdict(),
            "outliers_s": trial.outliers,
            "weights": trial.weights,
            "warnings": trial.notes,
        }
        for index, (bag, trial) in enumerate(zip(bags, _loaded(outcome), strict=True))
    ]


def _loaded(outcome: Outcome) -> tuple[Trial, ...]:
    """Return the trials as they were loaded, before any were averaged."""
    return *outcome.loaded.fit, *outcome.loaded.holdout


def _search(outcome: Outcome) -> Section:
    found = outcome.identification
    options, search = found.options, found.search
    return {
        "method": options.method or "iga",
        "cut_short": options.method is None,
        "seed": options.seed,
        "population": options.search.population,
        "generations": len(search.history) - 1,
        "evaluations": search.evaluations,
        "best": dict(zip(SYMBOLS, search.best, strict=True)),
        "sse": search.error,
        "seconds": outcome.search_seconds,
        "history": search.history,
        "stopped": search.stopped,
    }


def _whole_swings(found: WholeSwings | None, inertia: float) -> Section | None:
    if found is None:
        return None
    noise = found.noise
    return {
        "noise_rad": dict(zip(JOINTS, noise.encoders, strict=True)),
        "noise_memory": dict(zip(JOINTS, noise.memory, strict=True)),
        "missing_torque": dict(zip(JOINTS, inertia * found.torque, strict=True)),
        "swings": len(found.states),
        "steps": found.steps,
    }


def _repeatability(found: Identification) -> Section | None:
    compared = found.repeatability
    if compared is None:
        return None
    names = [group.symbol for group in GROUPS]
    return {
        "agree": compared.agree,
        "p_value": compared.p_value,
        "trials": [
            {
                "trial": trial,
                "groups": {
                    name: {"value": value, "std": std}
                    for name, value, std in zip(names, values, deviations, strict=False)
                },
            }
            for trial, values, deviations in zip(compared.trials, compared.values, compared.std, strict=True)
        ],
    }


def _new_trial(check: NewTrialCheck) -> Section:
    return {
        "trial": check.trial,
        "rmse_rad": check.error,
        "expected_rmse_rad": check.expected,
        "fits": check.fits,
        "changed": check.changed,
    }


def _doubts(new_trials: Sequence[NewTrialCheck]) -> Iterator[FitWarning]:
    for check in new_trials:
        warning = check.warning()
        if warning:
            yield warning


def _failures(traced: Trace, failures: Sequence[str]) -> Iterator[FitWarning]:
    if traced.failure:
        yield FitWarning("fit_failed", (), traced.failure)
    if failures:
        yield FitWarning("not_computed", (), f"what could not be computed is left out: {'; '.join(failures)}")


def _not_followed(outcome: Outcome) -> Iterator[FitWarning]:
    longer, data = outcome.trace.longer, outcome.identification.data
    if longer:
        times = longer.error / data.noise_level
        yield FitWarning(
            "not_followed",
            (),
            f"the motion is followed for half a swing only: over windows of {longer.duration:.3g} s, the best model "
            f"left {1e3 * longer.error:.3g} mrad of held-out motion, {times:.0f} times the noise. So the errors here "
            f"are over windows of {data.window:.2g} s; simulations that go on for longer are off by more",
        )


def _identifiability(completed: Identification) -> Section:
    determined = identifiability(completed)
    return {
        "directions": determined.directions,
        "undetermined": determined.undetermined,
        "unseen_changes": [tradeoff.changes for tradeoff in determined.unobservable],
        "determined_physical": determined.determined_physical,
        "physical_changes_without_effect": [tradeoff.changes for tradeoff in determined.tradeoffs],
        "to_measure": determined.to_measure,
        "words": determined.words,
    }


def _run(outcome: Outcome) -> Section:
    loaded = outcome.loaded
    return {
        "written_at": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "seconds": outcome.seconds,
        "versions": versions(),
        "options": loaded.job.settings.values(),
        "bag_sha256": {str(bag): files for bag, files in loaded.checksums.items()},
    }
