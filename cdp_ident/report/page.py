# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A document as a page that needs nothing beside itself; text from bags and files stays text.

That of a report has everything in it, its pendulum included.
"""

import base64
import gzip
import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from cdp_ident.model.acting import outer_rod_length
from cdp_ident.report.chapters import base_parameters
from cdp_ident.report.curves import Curves
from cdp_ident.report.document import Document
from cdp_ident.report.figures.for_page import Arrays, plotly_figure
from cdp_ident.report.figures.motion import shown_samples
from cdp_ident.report.figures.palette import DARK, LIGHT
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import models, nominal_value, role_words

_LOADER = jinja2.PackageLoader("cdp_ident.report", "templates")
_PLOTLY = Path(__file__).parent / "templates" / "plotly-cartesian-3.7.0.min.js.gz"
"""plotly.js as its makers publish it for two axes: 1.4 of the 4.8 MB of all of it, 0.5 MB packed."""


def page_of(document: Document, report: Section | None = None, curves: Curves | None = None) -> str:
    """Return a document as a page; that of a report has its pendulum, too, drawn from its curves."""
    environment, arrays, scripts = _pages(), Arrays(), ["charts.js"]
    data = {"themes": {"light": LIGHT, "dark": DARK}, "arrays": arrays.texts}
    data["figures"] = {figure.name: plotly_figure(figure, arrays) for figure in document.figures}
    content: dict[str, Any] = {"document": document}
    if report and curves:
        scripts.append("player.js")
        data["player"] = _player(report, curves, arrays)
        content |= {"report": report, "models": models(report), "role": role_words}
        content["base"] = base_parameters(report, short=True)
    return environment.get_template("report.html" if report else "document.html").render(
        style=Markup(environment.get_template("style.css").render(light=LIGHT, dark=DARK)),
        plotly=_plotly(),
        scripts=[Markup(_LOADER.get_source(environment, name)[0]) for name in scripts],
        digest=_digest,
        data=data,
        **content,
    )


def _player(report: Section, curves: Curves, arrays: Arrays) -> dict[str, Any]:
    """Return what the moving pendulum is drawn from: the curves of the charts, and the lengths of the rods [m]."""
    every = shown_samples(curves)

    def angles(values: Any) -> list[Any]:
        return [arrays.keep(values[every, column]) for column in range(2)]

    return {
        "length": report["after"]["physical"]["L"]["value"],
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


@cache
def _pages() -> jinja2.Environment:
    """Return what holds the templates of pages, each of which is compiled once: that takes 0.05 s for a report."""
    return jinja2.Environment(loader=_LOADER, autoescape=True, undefined=jinja2.StrictUndefined)


@cache
def _plotly() -> tuple[str, str]:
    """Return plotly.js as base64 of gzip, which a browser unpacks, and its digest."""
    packed = _PLOTLY.read_bytes()
    return base64.b64encode(packed).decode("ascii"), _digest(gzip.decompress(packed).decode())


def _digest(script: str) -> str:
    """Return what the page names a script by: the browser runs no other."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
