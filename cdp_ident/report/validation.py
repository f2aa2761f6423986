"""What `report.json` holds of a model's predictions and residuals: validation as control engineers know it."""

from cdp_ident.diagnosis.prediction import Plan, Prediction, plan_of, predicted
from cdp_ident.diagnosis.whiteness import Correlations, Whiteness
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import Section


def prediction_section(outcome: Outcome) -> Section | None:
    """Return how the error of predictions grows, before and after; None where the trials are too short for any."""
    data, trace = outcome.identification.data, outcome.trace
    plan = plan_of(data)
    # The model over what was held out knows the zeros of trials held out, too.
    before = predicted(trace.before.holdout, data, plan)
    after = before if trace.after is trace.before else predicted(trace.after.holdout, data, plan)
    if before is None or after is None:
        return None
    return {**_planned(plan, after), "before": _prediction(before), "after": _prediction(after)}


def _planned(plan: Plan, prediction: Prediction) -> Section:
    return {
        "held_out": plan.held_out,
        "starts": len(plan.starts),
        "told_s": plan.fitted_span,
        "horizon_s": plan.horizon,
        "time_s": prediction.time,
    }


def _prediction(prediction: Prediction) -> Section:
    return {
        "median_rad": prediction.median,
        "upper_rad": prediction.upper,
        "within": [
            {"limit_deg": within.limit, "median_s": within.median, "longer": within.longer}
            for within in prediction.within
        ],
    }


def residuals_section(outcome: Outcome) -> Section:
    """Return how the residuals over what was held out are correlated, before and after."""
    trace = outcome.trace
    before = Whiteness.of(trace.before.holdout)
    after = before if trace.after is trace.before else Whiteness.of(trace.after.holdout)
    return {"interval_s": before.interval, "before": _whiteness(before), "after": _whiteness(after)}


def _whiteness(found: Whiteness) -> Section:
    return {
        "white": found.white,
        "theta1": _correlations(found.theta1),
        "theta2": _correlations(found.theta2),
        "crosswise": _correlations(found.crosswise),
        "cart": found.cart
        and {name: _correlations(of) for name, of in zip(("theta1", "theta2"), found.cart, strict=True)},
    }


def _correlations(found: Correlations) -> Section:
    return {"values": found.values, "bound": found.bound, "related": found.related}
