"""What `report.json` says of a fitted model: its values, its errors, its predictions and its residuals."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from cdp_ident.diagnosis.evaluation import Errors, ErrorsByRole
from cdp_ident.diagnosis.identifiability import is_determined
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.diagnosis.prediction import Prediction, plan_of, predicted
from cdp_ident.diagnosis.whiteness import Correlations, Whiteness
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import Window
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.report.curves import Array
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import Section
from cdp_ident.tracing.trace import Trace

_Found = TypeVar("_Found")


def fit_section(found: Identification) -> Section:
    """Return what a fitted model is: physical values, base parameters, and how sure they are."""
    model, values, physical, inertia = found.fit.model, found.fit.values, found.physical, found.inertia
    std = np.sqrt(np.diag(found.covariance))
    numbers = zip(PARAMETERS, physical.values, physical.std, physical.determined, strict=True)
    section = {parameter.symbol: _quantity(parameter.unit, *number) for parameter, *number in numbers}
    for constant, value in zip(CONSTANTS, model.constants(values), strict=True):
        fitted = constant.symbol in model.names
        deviation = std[model.names.index(constant.symbol)] if fitted else 0.0
        section[constant.symbol] = _quantity(constant.unit, value, deviation, is_determined(value, deviation))
    determined = inertia.shown and is_determined(inertia.value, inertia.std)
    section[INERTIA.symbol] = _quantity(INERTIA.unit, inertia.value, inertia.std, determined)
    errors = zip(model.weight_errors, values[model.of_weights], std[model.of_weights], strict=True)
    return {
        "physical": section,
        "physical_possible": physical.possible,
        "outer_rod_length_m": model.mechanism.outer_length,
        "groups": {
            group.symbol: _quantity(group.unit, value, deviation, is_determined(value, deviation))
            for group, value, deviation in zip(GROUPS, values, std, strict=False)
        },
        "weight_errors": [
            {"of": of, "rod": rod, "given": given, "value": value, "std": deviation}
            for (of, rod, given), value, deviation in errors
        ],
        "correlation": _correlation(model, found.covariance),
    }


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


def _quantity(unit: str, value: float, std: float, determined: bool) -> Section:
    return {"value": value, "std": std, "unit": unit, "determined": determined}


def errors_section(data: Data, errors: ErrorsByRole) -> Section:
    """Return the errors of a model over the motion of each role."""
    return {"fit": _error(errors.fit, data.fit), "holdout": _error(errors.holdout, data.holdout)}


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
        "before": _prediction(before),
        "after": _prediction(after),
    }


def _prediction(found: Prediction) -> Section:
    within = [{"limit_deg": one.limit, "median_s": one.median, "longer": one.longer} for one in found.within]
    return {"median_rad": found.median, "upper_rad": found.upper, "within": within}


def residuals_section(trace: Trace) -> Section:
    """Return how the residuals over what was held out are correlated, before and after."""
    before, after = _before_and_after(trace, Whiteness.of)
    return {"interval_s": before.interval, "before": _whiteness(before), "after": _whiteness(after)}


def _whiteness(found: Whiteness) -> Section:
    return {
        "white": found.white,
        "theta1": _correlations(found.theta1),
        "theta2": _correlations(found.theta2),
        "crosswise": _correlations(found.crosswise),
        "cart": found.cart and dict(zip(("theta1", "theta2"), map(_correlations, found.cart), strict=True)),
    }


def _correlations(found: Correlations) -> Section:
    return {"values": found.values, "bound": found.bound, "related": found.related}
