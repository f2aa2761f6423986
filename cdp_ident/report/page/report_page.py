"""`report.html`, a report with everything in it, and `report.md`, the same as text with links to its figures."""

from typing import Any

from cdp_ident.model.acting import outer_rod_length
from cdp_ident.report.curves import Curves
from cdp_ident.report.figures.description import Figure
from cdp_ident.report.figures.for_page import Arrays
from cdp_ident.report.figures.models import models
from cdp_ident.report.figures.motion import shown_samples
from cdp_ident.report.formatting import number
from cdp_ident.report.page.rendering import render_page, render_text
from cdp_ident.report.page.words import words
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import nominal_value


def report_html(report: Section, curves: Curves, shown: list[Figure]) -> str:
    """Return `report.html`.

    Raises:
        ReportError: plotly is not installed.
    """
    arrays = Arrays()
    content = {**words(report), "report": report, "models": models(report)}
    data = {"player": _player(report, curves, arrays)}
    return render_page("report.html", shown, content, data, arrays, ("charts.js", "player.js"))


def report_md(report: Section, shown: list[Figure]) -> str:
    """Return `report.md`."""
    return render_text("report.md", shown, {**words(report), "r": report})


def _player(report: Section, curves: Curves, arrays: Arrays) -> dict[str, Any]:
    """Return what the moving pendulum is drawn from: the curves of the charts, and the lengths of the rods [m]."""
    every = shown_samples(curves)

    def angles(values: Any) -> list[Any]:
        return [arrays.keep(values[every, column]) for column in range(2)]

    return {
        "length": number(report["after"]["physical"]["L"]["value"]),
        "outer_length": outer_rod_length(nominal_value(report, "L"), nominal_value(report, "l2")),
        "trials": [
            {
                "time": arrays.keep(curve.time[every]),
                "cart": arrays.keep(curve.cart[every]),
                "measured": angles(curve.measured),
                "run": {model.key: angles(getattr(curve, f"run_{model.key}")) for model in models(report)},
                "windows": {model.key: angles(getattr(curve, model.key)) for model in models(report)},
            }
            for curve in curves.trials
        ],
    }
