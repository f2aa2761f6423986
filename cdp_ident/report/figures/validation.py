"""How far ahead the models predict, and what is left in their residuals."""

from collections.abc import Iterator

import numpy as np

from cdp_ident.report.figures.description import Axis, Figure, Line, Panel
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import models, predicted_for


def prediction(report: Section) -> Iterator[Figure]:
    """Yield how the error of predictions grows with the time that they look ahead."""
    ahead = report["prediction"]
    if ahead is None:
        return
    time, limits = np.array(ahead["time_s"]), [within["limit_deg"] for within in ahead["before"]["within"]]
    lines = []
    for model in models(report):
        upper = f"{model.key}: a quarter of the starts exceed"
        for key, label, width in (("median_rad", model.label, 2.5), ("upper_rad", upper, 1.0)):
            errors = np.degrees(ahead[model.key][key])
            drawn = np.where(np.isfinite(errors) & (errors > 0.0), errors, np.nan)
            lines.append(Line(label, model.key, time, drawn, width, dashed=model.key == "before"))
    lines += [Line(f"{limit:.3g}°", "noise", time[[0, -1]], np.full(2, limit), 1.0) for limit in limits]
    where = "held-out trials" if ahead["held_out"] else "the trials"
    said = "; ".join(f"within {limit:.3g}° for {predicted_for(report, k)} s" for k, limit in enumerate(limits))
    yield Figure(
        "prediction",
        "How far ahead the model predicts",
        "The larger error of both angles over the time since the last angle that its state was fitted to: the median "
        f"of {ahead['starts']} starts in {where}, and thin the upper quartile. The state at a start is fitted "
        f"to the {ahead['told_s']:.2g} s before it.",
        f"Predicted {said}.",
        [Panel(Axis("time ahead [s]"), Axis("error of the prediction [°]", logarithmic=True), lines, height=260)],
    )


def residual_correlation(report: Section) -> Figure:
    """Return the correlations of the residuals, in time and with each other, and with the cart where it moves."""
    found = report["residuals"]
    titles = {"theta1": "θ1 with itself", "theta2": "θ2 with itself", "crosswise": "θ1 with θ2 later"}
    if found["after"]["cart"]:
        titles |= {f"cart.theta{k}": f"the cart's acceleration with θ{k} later" for k in (1, 2)}
    said = (f"{m.label}: {'white' if found[m.key]['white'] else 'correlated in time'}" for m in models(report))
    return Figure(
        "residual_correlation",
        "What is left in the residuals",
        "Correlation of the residuals over held-out windows. Between the dotted lines all lags together are in 99 % of "
        "cases where nothing but white noise is left; lag 0 does not count."
        " An outer encoder that rides on the inner rod brings the inner one's noise into both angles.",
        f"Residuals are, {'; '.join(said)}.",
        [_panel(report, key, title) for key, title in titles.items()],
    )


def _panel(report: Section, key: str, title: str) -> Panel:
    marks, ends, bound = [], np.zeros(2), 0.0
    for model in models(report):
        found = report["residuals"][model.key]
        for part in key.split("."):
            found = found[part]
        values, bound = np.array(found["values"]), found["bound"]
        first = 0 if key in ("theta1", "theta2") else -(len(values) // 2)
        lags = 1e3 * report["residuals"]["interval_s"] * np.arange(first, first + len(values))
        ends = lags[[0, -1]]
        marks.append(Line(model.label, model.key, lags, values, marked=True, dashed=model.key == "before"))
    # The bounds are of the final model.
    marks += [Line("99 % bounds", "noise", ends, np.full(2, sign * bound), 1.0, dashed=True) for sign in (-1, 1)]
    return Panel(Axis("lag [ms]"), Axis("correlation", limits=(-1.05, 1.05)), marks, title, 130)
