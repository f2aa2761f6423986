# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well the models follow the motion: their errors, how far ahead they predict, what is left in the residuals."""

from collections.abc import Iterator

import numpy as np

from cdp_ident.report.document import Charts, Parts, Sentences, Table
from cdp_ident.report.figures.description import Axis, Bars, Figure, Line, Mark, Panel, beside, level, named
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import milliradians, models, noise_floor, per_cent

_ANGLES = ("theta1", "theta2")
_STAGES = {"nominal": "nominal values", "search": "after the search", "refined": "refined"}
_WHERE = {"holdout": "held out", "fit": "fitted"}


def validation(report: Section) -> Parts:
    """Return the chapter: what is where control engineers look, the errors of each stage, and pictures."""
    stages = [(label, report["stages"][stage]) for stage, label in _STAGES.items()]
    if report["effects"]:
        stages.append(("with the effects found", report["after"]["error"]))
    window = report["before"]["error"]["fit"]["window_s"]
    fits = ("NRMSE fit of θ1 and θ2 [%]", "held out [%]")
    rows = [
        (
            label,
            *(milliradians(of_model[role]["rmse_rad"]) for role in ("fit", "holdout")),
            f"{of_model['holdout']['sse_free_run']:.4g}",
            *(" and ".join(_fits(of_model[role])) for role in ("fit", "holdout")),
        )
        for label, of_model in stages
    ]
    noise = " and ".join(map(milliradians, report["noise_rad"].values()))
    return (
        Sentences.of(validation_words(report)),
        Table(
            f"Error, measured against simulated, over windows of {window:.3g} s",
            ("model", "fit [mrad]", "held out [mrad]", "Eq. (10), held out [rad²]", *fits),
            [*rows, ("the encoders' noise", noise, "", "", "", "")],
            wide=fits,
        ),
        Charts([*prediction(report), residual_correlation(report)], side_by_side=True),
    )


def _fits(error: Section) -> list[str]:
    return [per_cent(error[f"fit_{angle}_percent"]) for angle in _ANGLES]


def predicted_for(report: Section, limit: int) -> str:
    """Say for how long the models predict within one of the limits, by its place, in seconds without the unit."""
    within = [report["prediction"][model.key]["within"][limit] for model in models(report)]
    return " -> ".join(f"{'≥ ' if one['longer'] else ''}{one['median_s']:.3g}" for one in within)


def validation_words(report: Section) -> Iterator[str]:
    """Say how the models do where control engineers look: fit in per cent, prediction, and residuals."""
    of_angles = zip(*(_fits(report[model.key]["error"]["holdout"]) for model in models(report)), strict=True)
    said = ", ".join(f"{angle} {' -> '.join(fits)} %" for angle, fits in zip(_ANGLES, of_angles, strict=True))
    yield f"fit over held-out windows (NRMSE, as of MATLAB's compare): {said}"
    if ahead := report["prediction"]:
        said = ", ".join(
            f"within {within['limit_deg']:.3g}° for {predicted_for(report, place)} s"
            for place, within in enumerate(ahead["before"]["within"])
        )
        where = "in held-out trials" if ahead["held_out"] else "in the trials, fitted motion among it"
        yield (
            f"after {ahead['told_s']:.2g} s of measured motion, the model predicts {said} (median of "
            f"{ahead['starts']} starts {where})"
        )
    found = report["residuals"]["after"]
    if found["white"]:
        yield "residuals over held-out windows: white"
    else:
        said = " and ".join(
            f"{max(map(abs, found[angle]['values'][1:])):.2f} in {angle} (chance: {found[angle]['bound']:.2f})"
            for angle in _ANGLES
            if found[angle]["related"]
        )
        yield f"residuals over held-out windows are correlated in time, by up to {said}"
    if found["crosswise"]["related"]:
        yield "those of the two angles are correlated with each other"
    if found["cart"] and any(of["related"] for of in found["cart"].values()):
        yield "they have to do with the cart's acceleration: the model lacks a part of its effect"


def before_and_after(report: Section) -> Figure:
    """Return the errors over motion of each role as bars."""
    shown, marks = models(report), list[Mark]()
    for index, model in enumerate(shown):
        errors = [1e3 * report[model.key]["error"][role]["rmse_rad"] for role in _WHERE]
        words = [f"{error:.3g}" for error in errors]
        marks.append(Bars(model.label, model.key, errors, beside(index, len(shown), 0.38, len(_WHERE)), words, 0.34))
    floor, roles = 1e3 * noise_floor(report), named(_WHERE.values())
    marks.append(level("the encoders' noise", "noise", floor, roles))
    window = report["before"]["error"]["holdout"]["window_s"]
    return Figure(
        "errors",
        "Error before and after",
        f"Root mean square of measured less simulated angles over windows of {window:.2g} s, on the motion that was "
        "fitted, and on motion that neither fit nor choice has seen.",
        [Panel(Axis("error [mrad]"), roles, marks, height=60.0 + 50.0 * len(shown))],
    )


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
            lines.append(Line(label, model.key, time, drawn, width, model.dash))
    lines += [Line(f"{limit:.3g}°", "noise", time[[0, -1]], np.full(2, limit), 1.0) for limit in limits]
    where = "held-out trials" if ahead["held_out"] else "the trials"
    yield Figure(
        "prediction",
        "How far ahead the model predicts",
        "The larger error of both angles over the time since the last angle that its state was fitted to: the median "
        f"of {ahead['starts']} starts in {where}, and thin the upper quartile. The state at a start is fitted "
        f"to the {ahead['told_s']:.2g} s before it.",
        [Panel(Axis("time ahead [s]"), Axis("error of the prediction [°]", logarithmic=True), lines, height=260)],
    )


def residual_correlation(report: Section) -> Figure:
    """Return the correlations of the residuals, in time and with each other, and with the cart where it moves."""
    found = report["residuals"]
    titles = {"theta1": "θ1 with itself", "theta2": "θ2 with itself", "crosswise": "θ1 with θ2 later"}
    if found["after"]["cart"]:
        titles |= {f"cart.{angle}": f"the cart's acceleration with θ{angle[-1]} later" for angle in _ANGLES}
    return Figure(
        "residual_correlation",
        "What is left in the residuals",
        "Correlation of the residuals over held-out windows. Between the dotted lines all lags together are in 99 % of "
        "cases where nothing but white noise is left; lag 0 does not count."
        " An outer encoder that rides on the inner rod brings the inner one's noise into both angles.",
        [_correlations(report, key, title) for key, title in titles.items()],
    )


def _correlations(report: Section, key: str, title: str) -> Panel:
    marks, ends, bound = [], np.zeros(2), 0.0
    for model in models(report):
        found = report["residuals"][model.key]
        for part in key.split("."):
            found = found[part]
        values, bound = np.array(found["values"]), found["bound"]
        first = 0 if key in _ANGLES else -(len(values) // 2)
        lags = 1e3 * report["residuals"]["interval_s"] * np.arange(first, first + len(values))
        ends = lags[[0, -1]]
        marks.append(Line(model.label, model.key, lags, values, 1.5, model.dash, "circle"))
    # The bounds are of the final model.
    marks += [Line("99 % bounds", "noise", ends, np.full(2, sign * bound), 1.0, "dash") for sign in (-1, 1)]
    return Panel(Axis("lag [ms]"), Axis("correlation", limits=(-1.05, 1.05)), marks, title, 130)
