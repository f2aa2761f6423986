"""`report.html`: a report with everything in it, its pendulum included."""

from typing import Any

from cdp_ident.model.acting import outer_rod_length
from cdp_ident.report.chapters import base_parameters
from cdp_ident.report.curves import Curves
from cdp_ident.report.figures.for_page import Arrays
from cdp_ident.report.figures.motion import shown_samples
from cdp_ident.report.formatting import number
from cdp_ident.report.page.rendering import render_page
from cdp_ident.report.parts import Document
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import models, nominal_value, role_words


def report_html(report: Section, curves: Curves, document: Document) -> str:
    """Return `report.html`.

    Raises:
        ReportError: plotly is not installed.
    """
    arrays = Arrays()
    content = {
        "report": report,
        "models": models(report),
        "role": role_words,
        "base": base_parameters(report, short=True),
    }
    player = _player(report, curves, arrays)
    return render_page(document, "report.html", content, {"player": player}, arrays, ("charts.js", "player.js"))


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
