# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The errors of a report: before and after, ahead in time, along the search and along the selection of effects."""

import math
import textwrap
from collections.abc import Iterator, Sequence

import numpy as np

from cdp_ident.report.figures.description import Axis, Bars, Figure, Line, Mark, Panel, beside, level, named
from cdp_ident.report.figures.palette import Colour
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import (
    action_words,
    chance,
    effects_words,
    key_words,
    models,
    noise_floor,
    odds,
    predicted_for,
)

_LABEL_WIDTH = 22
"""Characters in a line of a name beside an axis: two thirds of a phone remain beside it."""
_ROOM = 27.0
"""Height of a bar with a name of two lines [pixels]."""
GENERATION = Axis("generation")
_WHERE = {"holdout": "held out", "fit": "fitted"}
_ODDS = Axis("log10 of the odds")


def wrapped(name: str) -> str:
    """Break a name that stands beside an axis into lines."""
    return "\n".join(textwrap.wrap(name, _LABEL_WIDTH))


def before_and_after(report: Section) -> Figure:
    """Return the errors over motion of each role as bars."""
    shown, marks, said = models(report), list[Mark](), []
    for index, model in enumerate(shown):
        errors = [1e3 * report[model.key]["error"][role]["rmse_rad"] for role in _WHERE]
        words = [f"{error:.3g}" for error in errors]
        marks.append(Bars(model.label, model.key, beside(index, len(shown), 0.38, len(_WHERE)), errors, words, 0.34))
        said.append(f"{model.label}: {', '.join(map('{} mrad {}'.format, words, _WHERE.values()))}")
    floor = 1e3 * noise_floor(report)
    roles = named(_WHERE.values())
    marks.append(level("the encoders' noise", "noise", floor, roles))
    window = report["before"]["error"]["holdout"]["window_s"]
    return Figure(
        "errors",
        "Error before and after",
        f"Root mean square of measured less simulated angles over windows of {window:.2g} s, on the motion that was "
        "fitted, and on motion that neither fit nor choice has seen.",
        f"{'; '.join(said)}; the encoders' noise: {floor:.3g} mrad.",
        [Panel(Axis("error [mrad]"), roles, marks, height=60.0 + 50.0 * len(shown))],
    )


def best_error(report: Section) -> Iterator[Figure]:
    """Yield the search's best error over its generations, where it was not cut short to a few."""
    search = report["search"]
    if search["cut_short"]:
        return
    history = np.array(search["history"])
    name = search["method"].upper()
    yield Figure(
        "best_error",
        "Evolution of the best error",
        f"Squared error (Eq. 10) of the best chromosome after each generation of the search ({name}), from which the "
        "refinement starts. As the paper's Figs. 7, 9 and 13.",
        f"From {history[0]:.4g} to {history[-1]:.4g} rad² in {len(history) - 1} generations.",
        [evolution([Line(name, "after", np.arange(len(history), dtype=float), history, 2.0)])],
    )


def evolution(lines: Sequence[Line]) -> Panel:
    """Return best errors over the generations of searches."""
    return Panel(GENERATION, Axis("best error E(Z) [rad²]", logarithmic=True), lines, height=260)


def selection(report: Section) -> Iterator[Figure]:
    """Yield how probable each model that was tried is beside the one before, step by step."""
    panels, said = [], []
    for index, step in enumerate(report["selection"]["steps"], start=1):
        if tried := [one for one in step["tried"] if math.isfinite(one["log10_odds"])]:
            panels.append(_step(f"Step {index}: {action_words(step)}", tried))
            best = max(one["log10_odds"] for one in tried)
            said.append(f"step {index}, {action_words(step)}: at best {best:.3g}")
    if panels:
        yield Figure(
            "selection",
            "What was tried",
            "Each model that was fitted at a step, named by the effects that it has more or has no longer, and how "
            "probable it is beside the one before: the decimal logarithm of its odds. What lies left of zero is less "
            "probable.",
            f"Decimal logarithms of odds over the model before: {'; '.join(said)}.",
            panels,
        )


def _step(title: str, tried: list[Section]) -> Panel:
    names = [wrapped(effects_words(one["effects"])) for one in tried]
    odds = [one["log10_odds"] for one in tried]
    # A bar has the room that its name needs: one line or two, or more.
    rooms = np.array([max(1.0, (name.count("\n") + 1) / 2) for name in names])
    places = (np.cumsum(rooms) - rooms / 2).tolist()
    best = int(np.argmax(odds))
    marks: list[Mark] = []
    kinds: tuple[tuple[str, Colour, bool], ...] = (("taken", "after", True), ("tried, not taken", "noise", False))
    for label, colour, is_taken in kinds:
        if of := [k for k, one in enumerate(odds) if (k == best and one > 0.0) is is_taken]:
            words = [f"{odds[k]:.3g}" for k in of]
            marks.append(Bars(label, colour, [places[k] for k in of], [odds[k] for k in of], words))
    axis = Axis(ticks=list(zip(places, names, strict=True)))
    marks.append(level("as probable as before", "before", 0.0, axis))
    height = 45.0 + _ROOM * float(rooms.sum())
    return Panel(_ODDS, axis, marks, title, height)


def candidates(report: Section) -> Iterator[Figure]:
    """Yield how probable the model would be with each effect that it does not have."""
    best: dict[str, Section] = {}
    for one in report["selection"]["candidates"]:
        if math.isfinite(one["log10_odds"]):
            best.setdefault(key_words(".".join(one["effect"].split(".")[:2])), one)
    if not best:
        return
    lengths = [one["log10_odds"] for one in best.values()]
    words = [f"{odds(one['log10_odds'])}, {chance(one['probability'])}" for one in best.values()]
    bars = Bars("with it", "noise", beside(0, 1, 0.0, len(best)), lengths, words)
    names = named(best)
    marks: list[Mark] = [bars, level("as probable as without it", "before", 0.0, names)]
    yield Figure(
        "candidates",
        "What else was looked for",
        "The model with one effect more beside the model without it, before any fit: odds, and the probability that "
        "the effect is there; of an effect with several forms those of the best one. Left of zero the trials speak "
        "against it.",
        f"{'; '.join(map('{}: {}'.format, best, words))}.",
        [Panel(_ODDS, names, marks, height=40.0 + 20.0 * len(best))],
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
        [_correlations(report, key, title) for key, title in titles.items()],
    )


def _correlations(report: Section, key: str, title: str) -> Panel:
    marks, ends, bound = [], np.zeros(2), 0.0
    for model in models(report):
        found = report["residuals"][model.key]
        for part in key.split("."):
            found = found[part]
        values, bound = np.array(found["values"]), found["bound"]
        first = 0 if key in ("theta1", "theta2") else -(len(values) // 2)
        lags = 1e3 * report["residuals"]["interval_s"] * np.arange(first, first + len(values))
        ends = lags[[0, -1]]
        marks.append(Line(model.label, model.key, lags, values, 1.5, model.dash, "circle"))
    # The bounds are of the final model.
    marks += [Line("99 % bounds", "noise", ends, np.full(2, sign * bound), 1.0, "dash") for sign in (-1, 1)]
    return Panel(Axis("lag [ms]"), Axis("correlation", limits=(-1.05, 1.05)), marks, title, 130)
