"""The contents of `report.json`."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime, timezone
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.evaluation import Errors, ErrorsByRole
from cdp_ident.diagnosis.identifiability import Identifiability, Tradeoff, identifiability, is_determined
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.diagnosis.inertia import Inertia
from cdp_ident.diagnosis.new_trial import NewTrialCheck
from cdp_ident.diagnosis.warnings import FitWarning, find_warnings, outlier_warnings
from cdp_ident.fit.data import Data
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.physical import PhysicalValues
from cdp_ident.fit.windows import Window
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.outside_text import shown
from cdp_ident.report.earlier import compared
from cdp_ident.report.next_trial import next_trial_section
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.provenance import versions
from cdp_ident.report.schema import SCHEMA, Section
from cdp_ident.report.schema_terms import LONGEST_TEXT
from cdp_ident.report.validation import prediction_section, residuals_section
from cdp_ident.report.verdict import effect_in_words, verdict
from cdp_ident.tracing.found_effects import FoundCurve
from cdp_ident.tracing.trace import Trace
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]


def report(outcome: Outcome, new_trials: Sequence[NewTrialCheck] = ()) -> Section:
    """Return everything there is to report; plain values, to be written as JSON, as `schema.py` states it.

    Texts from outside, such as the names of bags, are fit to be shown.

    Args:
        outcome: what was found.
        new_trials: how trials that came later fitted before they were seen, in the order in which they came.
    """
    found = outcome.identification
    after, completed = outcome.trace.after, outcome.trace.completed
    determined = identifiability(
        after.fit, completed.covariance, completed.physical, completed.inertia, found.options.prior, found.data.names
    )
    return dict(shown_texts(_report(outcome, new_trials, found, determined)))


def shown_texts(content: Any) -> Any:
    """Return contents of a report whose texts are all fit to be shown."""
    if isinstance(content, str):
        return shown(content, LONGEST_TEXT)
    if isinstance(content, Mapping):
        return {shown(key, LONGEST_TEXT): shown_texts(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [shown_texts(value) for value in content]
    return content


def _report(
    outcome: Outcome, new_trials: Sequence[NewTrialCheck], found: Identification, determined: Identifiability
) -> Section:
    after, completed = outcome.trace.after, outcome.trace.completed
    failures, expected = list(outcome.trace.failures), outcome.loaded.job.expected
    next_trial = next_trial_section(outcome, failures.append)
    return {
        "schema": SCHEMA,
        "trials": _trials(outcome),
        "noise_rad": {"theta1": float(found.data.noise[0]), "theta2": float(found.data.noise[1])},
        "search": _search(outcome),
        "stages": {
            stage: _errors(found.data, errors) for stage, errors in outcome.trace.errors.items() if stage != "effects"
        },
        "before": fit_section(
            found.fit.model,
            found.fit.values,
            found.covariance,
            found.physical,
            found.inertia,
            _errors(found.data, outcome.trace.errors["refined"]),
        ),
        "refinement": {
            "iterations": found.fit.iterations,
            "simulations": found.fit.simulations,
            "converged": found.fit.converged,
            "windows": {
                "fit": len(found.data.fit),
                "holdout": len(found.data.holdout),
            },
        },
        "effects": [_effect(outcome, index) for index in range(len(outcome.trace.effects))],
        "after": fit_section(
            after.model,
            after.fit.values,
            completed.covariance,
            completed.physical,
            completed.inertia,
            _errors(found.data, outcome.trace.errors["effects"]),
        ),
        "unexplained": {
            "significant": outcome.trace.unexplained.significant,
            "joint": outcome.trace.unexplained.joint,
            "times_noise": outcome.trace.unexplained.times_noise,
            "description": outcome.trace.unexplained.description,
        },
        "verdict": verdict(outcome.trace),
        "prediction": prediction_section(outcome),
        "residuals": residuals_section(outcome),
        "next_trial": next_trial,
        "selection": _selection(outcome.trace),
        "continuity": _continuity(completed),
        "repeatability": _repeatability(completed),
        "expected": compared(expected, outcome.trace.effects) if expected else [],
        "new_trials": [_new_trial(check) for check in new_trials],
        "identifiability": _identifiability(determined),
        "warnings": [
            {"name": warning.name, "about": list(warning.about), "message": warning.message}
            for warning in (
                *_doubts(new_trials),
                *_failures(outcome.trace, failures),
                *outlier_warnings(_loaded(outcome)),
                *find_warnings(completed),
            )
        ],
        "run": _run(outcome),
    }


def fit_section(
    model: MotionModel, values: Array, covariance: Array, physical: PhysicalValues, inertia: Inertia, error: Section
) -> Section:
    """Return what a fitted model is: physical values, groups and errors.

    Args:
        model: the model.
        values: (unknowns,) its fitted values, the groups first.
        covariance: (unknowns, unknowns) their covariance.
        physical: the physical values chosen for the groups.
        inertia: A22.
        error: its errors, as `_errors` gives them.
    """
    std = np.sqrt(np.diag(covariance))
    numbers = zip(PARAMETERS, physical.values, physical.std, physical.determined, strict=True)
    section = {
        parameter.symbol: _quantity(value, deviation, parameter.unit, sure)
        for parameter, value, deviation, sure in numbers
    }
    for constant, value in zip(CONSTANTS, model.constants(values), strict=True):
        fitted = constant.symbol in model.names
        deviation = std[model.names.index(constant.symbol)] if fitted else 0.0
        section[constant.symbol] = _quantity(value, deviation, constant.unit, is_determined(value, deviation))
    determined = inertia.shown and is_determined(inertia.value, inertia.std)
    section[INERTIA.symbol] = _quantity(inertia.value, inertia.std, INERTIA.unit, determined)
    return {
        "physical": section,
        "physical_possible": physical.possible,
        "outer_rod_length_m": model.mechanism.outer_length,
        "groups": {
            group.symbol: _quantity(value, deviation, group.unit, is_determined(value, deviation))
            for group, value, deviation in zip(GROUPS, values, std, strict=False)
        },
        "weight_errors": _weight_errors(model, values, std),
        "correlation": _correlation(model, covariance),
        "error": error,
    }


def _weight_errors(model: MotionModel, values: Array, std: Array) -> list[Section]:
    estimates = zip(model.weight_errors, values[model.of_weights], std[model.of_weights], strict=True)
    return [
        {"of": of, "rod": rod, "told": told, "value": float(value), "std": float(deviation)}
        for (of, rod, told), value, deviation in estimates
    ]


def _correlation(model: MotionModel, covariance: Array) -> Section:
    """Return how the errors of the estimates go together; not a number for one that the trials do not show.

    The coefficients of curves are not among them.
    """
    shown = ~model.of_curves
    covariance = covariance[np.ix_(shown, shown)]
    std = np.sqrt(np.diag(covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix = covariance / np.outer(std, std)
    return {
        "names": [name for name, is_shown in zip(model.names, shown, strict=True) if is_shown],
        "matrix": matrix.tolist(),
    }


def _quantity(value: float, std: float, unit: str, determined: bool) -> Section:
    return {"value": float(value), "std": float(std), "unit": unit, "determined": bool(determined)}


def _errors(data: Data, errors: ErrorsByRole) -> Section:
    return {
        "fit": _error(errors.fit, data.fit),
        "validation": _error(errors.validation, data.fit),
        "holdout": _error(errors.holdout, data.holdout),
    }


def _error(errors: Errors, windows: tuple[Window, ...]) -> Section:
    return {
        "rmse_rad": errors.rmse,
        "rmse_theta1_rad": errors.rmse_theta1,
        "rmse_theta2_rad": errors.rmse_theta2,
        "window_s": round(float(np.mean([window.duration for window in windows])), 3),
        "sse_free_run": errors.free_run,
        "fit_theta1_percent": errors.fit_theta1,
        "fit_theta2_percent": errors.fit_theta2,
    }


def _effect(outcome: Outcome, index: int) -> Section:
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


def _selection(traced: Trace) -> Section:
    selection = traced.selection
    return {
        "interrupted": selection.interrupted,
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
                        "delta_bic": tried.change.bic,
                    }
                    for tried in step.tried
                ],
            }
            for step in selection.steps
        ],
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
            "clock": trial.clock and {"fast": trial.clock.fast, "std": trial.clock.std},
            "outliers_s": list(trial.outliers),
            "weights": [vars(weight) for weight in trial.weights],
            "warnings": list(trial.notes),
        }
        for index, (bag, trial) in enumerate(zip(bags, _loaded(outcome), strict=True))
    ]


def _loaded(outcome: Outcome) -> tuple[Trial, ...]:
    """Return the trials as they were loaded, before any were averaged."""
    return *outcome.loaded.fit, *outcome.loaded.holdout


def _search(outcome: Outcome) -> Section:
    found = outcome.identification
    options, estimate = found.options, found.estimate
    return {
        "method": options.method or "iga",
        "cut_short": options.method is None,
        "seed": options.seed,
        "population": options.search.population,
        "generations": len(estimate.search.history) - 1,
        "searches": estimate.searches,
        "evaluations": estimate.evaluations,
        "sse": estimate.search.error,
        "seconds": outcome.search_seconds,
        "history": list(estimate.search.history),
        "stopped": estimate.search.stopped,
    }


def _continuity(found: Identification) -> Section | None:
    joined = found.continuity
    if joined is None:
        return None
    return {"rms_rad": joined.rms, "relative": joined.relative, "boundaries": joined.boundaries}


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
                    name: {"value": float(value), "std": float(std)}
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
        "changed": [
            {"name": c.name, "before": c.before, "alone": c.alone, "deviations": c.deviations} for c in check.changed
        ],
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


def _identifiability(found: Identifiability) -> Section:
    def changes(tradeoffs: tuple[Tradeoff, ...]) -> list[Mapping[str, float]]:
        return [tradeoff.changes for tradeoff in tradeoffs]

    return {
        "directions": [
            {"singular_value": direction.singular_value, "exponents": direction.exponents}
            for direction in found.directions
        ],
        "undetermined": list(found.undetermined),
        "unseen_changes": changes(found.unseen),
        "determined_physical": list(found.determined_physical),
        "physical_changes_without_effect": changes(found.tradeoffs),
        "to_measure": list(found.to_measure),
        "words": list(found.words),
    }


def _run(outcome: Outcome) -> Section:
    loaded = outcome.loaded
    return {
        "written_at": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "seconds": outcome.seconds,
        "versions": versions(),
        "options": loaded.job.settings.values(),
        "bag_sha256": {str(bag): dict(files) for bag, files in loaded.checksums.items()},
    }
