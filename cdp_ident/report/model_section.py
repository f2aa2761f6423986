"""What `report.json` says of a fitted model: its values, its errors, its predictions and its residuals."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from cdp_ident.diagnosis.evaluation import ErrorsByRole
from cdp_ident.diagnosis.identifiability import is_determined
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.diagnosis.prediction import plan_of, predicted
from cdp_ident.diagnosis.whiteness import Whiteness
from cdp_ident.fit.data import Data
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.report.curves import Array
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import Section
from cdp_ident.report.schema_terms import Also
from cdp_ident.tracing.trace import Trace

_Found = TypeVar("_Found")


def fit_section(found: Identification) -> Section:
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
    return {"names": np.array(model.names)[shown], "matrix": matrix}


def errors_section(data: Data, errors: ErrorsByRole) -> Section:
    """Return the errors of a model over the motion of each role."""
    roles = {"fit": (errors.fit, data.fit), "holdout": (errors.holdout, data.holdout)}
    return {
        role: Also(of, {"window_s": round(float(np.mean([window.duration for window in windows])), 3)})
        for role, (of, windows) in roles.items()
    }


def _before_and_after(trace: Trace, found: Callable[[Fit], _Found]) -> tuple[_Found, _Found]:
    """Return what is found of both models over what was held out: there they know the zeros of all encoders."""
    before = found(trace.before.holdout)
    return before, before if trace.after is trace.before else found(trace.after.holdout)


def prediction_section(outcome: Outcome) -> Section | None:
    """Return how the error of predictions grows, before and after; None where the trials are too short for any."""
    data = outcome.identification.data
    plan = plan_of(data)
    before, after = _before_and_after(outcome.trace, lambda fit: predicted(fit, data, plan))
    if before is None or after is None:
        return None
    return {
        "held_out": plan.held_out,
        "starts": len(plan.starts),
        "told_s": plan.fitted_span,
        "horizon_s": plan.horizon,
        "time_s": after.time,
        "before": before,
        "after": after,
    }


def residuals_section(trace: Trace) -> Section:
    """Return how the residuals over what was held out are correlated, before and after."""
    before, after = _before_and_after(trace, Whiteness.of)
    return {"interval_s": before.interval, "before": before, "after": after}
