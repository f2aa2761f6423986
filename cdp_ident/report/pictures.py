# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draws reports and other documents for people: as a page, as text and, for papers, with figures as files.

A page needs nothing beside itself; text from bags and files stays text. Its figures are what plotly.js takes, but for
arrays, colours and style, which the page puts in: an array stands as `{"array": name}` and is kept once however many
figures show it; a colour stands as `{"colour": name}`, because it depends on the theme. What all figures have alike is
in `templates/charts.js`.
"""

import base64
import gzip
import hashlib
import html
import textwrap
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from markupsafe import Markup

from cdp_ident.output_folder import finite, write_files
from cdp_ident.report.chapters import document_of
from cdp_ident.report.curves import Curves, read_curves
from cdp_ident.report.document import Document, markdown
from cdp_ident.report.figures.curves import shown_samples
from cdp_ident.report.figures.description import DARK, LIGHT, Axis, Bars, Figure, Heat, Mark
from cdp_ident.report.folder import CURVES, FIGURES, PAGE, REPORT, TEXT, drawn_with
from cdp_ident.report.parameters import base_parameters
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import models, role_words

if TYPE_CHECKING:
    import jinja2

Json = dict[str, Any]

_TEMPLATES = Path(__file__).parent / "templates"
_PLOTLY = _TEMPLATES / "plotly-cartesian-3.7.0.min.js.gz"
"""plotly.js as its makers publish it for two axes: 1.4 of the 4.8 MB of all of it, 0.5 MB packed."""
_TOP, _BOTTOM, _LINE = 14.0, 46.0, 16.0
"""What a panel needs above it and below for its axis, and a line of its title [pixels]."""
_TITLE_WIDTH = 24
"""Characters in a line of a panel's title: what a phone has room for."""


class Arrays:
    """The numbers of a page's figures, each array once: little-endian, four bytes a number."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}
        """Base64 of each array's bytes, by its name."""

    def keep(self, values: npt.ArrayLike) -> Json:
        """Keep an array, and return what stands for it."""
        data = np.ascontiguousarray(values, dtype="<f4").tobytes()
        name = hashlib.sha256(data).hexdigest()[:12]
        self.texts[name] = base64.b64encode(data).decode("ascii")
        return {"array": name}


def draw(folder: Path, for_paper: bool = False) -> None:
    """Draw the report in a folder: page and text; only `for_paper` the figures as files, to which the text links then.

    They are made of `report.json` and `curves.npz` alone. Page and figures that were drawn there before go.

    Raises:
        ReportError: there is no complete report in it.
        OptionError: it cannot be written to.
    """
    report = read_report(folder / REPORT)
    curves = read_curves(folder / CURVES, len(report["trials"]), len(report["effects"]))
    files = files_of(document_of(report, curves), PAGE, TEXT, for_paper, report, curves)
    write_files(folder, files, (PAGE, *drawn_with(folder)), below=(FIGURES,))


def files_of(
    document: Document,
    page: str,
    text: str,
    for_paper: bool,
    report: Section | None = None,
    curves: Curves | None = None,
) -> dict[str, str | bytes]:
    """Return the files of a document by their names: its page, its text and, only `for_paper`, its figures.

    The page of a `report` has what moves, too.
    """
    files: dict[str, str | bytes] = {page: page_of(document, report, curves), text: markdown(document, for_paper)}
    if for_paper:
        from cdp_ident.report.figures.for_paper import png_and_svg  # noqa: PLC0415 - only who draws waits for it

        for figure in document.figures:
            files[f"{FIGURES}/{figure.name}.png"], files[f"{FIGURES}/{figure.name}.svg"] = png_and_svg(figure)
    return files


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
        scripts=[Markup((_TEMPLATES / name).read_text(encoding="utf-8")) for name in scripts],
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
        "outer_length": report["after"]["outer_rod_length_m"],
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
def _pages() -> "jinja2.Environment":
    """Return what holds the templates of pages, each of which is compiled once: that takes 0.05 s for a report."""
    import jinja2  # noqa: PLC0415 - only who draws waits for it

    loader = jinja2.FileSystemLoader(_TEMPLATES)
    return jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)


@cache
def _plotly() -> tuple[str, str]:
    """Return plotly.js as base64 of gzip, which a browser unpacks, and its digest."""
    packed = _PLOTLY.read_bytes()
    return base64.b64encode(packed).decode("ascii"), _digest(gzip.decompress(packed).decode())


def _digest(script: str) -> str:
    """Return what the page names a script by: the browser runs no other."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")


def plotly_figure(figure: Figure, arrays: Arrays) -> Json:
    """Return data and layout of a figure."""
    titles = ["\n".join(textwrap.wrap(panel.title, _TITLE_WIDTH)) for panel in figure.panels]
    tops = [_TOP + _LINE * (title.count("\n") + 1) if title else _TOP for title in titles]
    last = len(figure.panels) - 1
    bottoms = [0.0 if figure.shared_x and index < last else _BOTTOM for index in range(last + 1)]
    inside = sum(tops[1:]) + sum(bottoms[:-1]) + sum(panel.height for panel in figure.panels)
    data = list[Json]()
    layout: Json = {
        "height": inside + tops[0] + bottoms[-1],
        "margin": {"t": tops[0], "b": bottoms[-1]},
        "hovermode": "x unified" if figure.shared_x else "closest",
        "shapes": [],
        "annotations": [],
    }
    top = inside
    for index, panel in enumerate(figure.panels):
        top -= tops[index] if index else 0.0
        suffix = str(index + 1) if index else ""
        low, high = max((top - panel.height) / inside, 0.0), min(top / inside, 1.0)
        x, y = "x" if figure.shared_x else f"x{suffix}", f"y{suffix}"
        data += [{**_trace(mark, arrays), "xaxis": x, "yaxis": y} for mark in panel.marks]
        layout[f"yaxis{suffix}"] = {**_axis(panel.y, "y"), "domain": [low, high], "anchor": x}
        if not figure.shared_x or index == last:
            layout[f"xaxis{x[1:]}"] = {**_axis(panel.x, "x"), "anchor": y}
        layout["shapes"] += [
            {"xref": x, "yref": f"{y} domain", "x0": begin, "x1": end, "y0": 0, "y1": 1}
            for begin, end in panel.held_out
        ]
        if titles[index]:
            layout["annotations"].append({"text": f"<b>{_literal(titles[index])}</b>", "x": 0, "y": high})
        top -= panel.height + bottoms[index]
    return {"data": finite(data), "layout": layout}


def _literal(text: str) -> str:
    """Return text that plotly.js shows as it is, where it would take a part of it for markup."""
    return html.escape(text, quote=False).replace("\n", "<br>")


def _trace(mark: Mark, arrays: Arrays) -> Json:
    if isinstance(mark, Heat):
        return _heat(mark)
    colour = {"colour": mark.colour}
    trace: Json = {"name": _literal(mark.label.partition(":")[0]), "meta": mark.label}
    trace["text"] = [_literal(words) for words in mark.words]
    if isinstance(mark, Bars):
        return trace | {
            "type": "bar", "x": mark.x, "y": mark.y, "width": mark.thickness,
            "marker": {"color": colour},
            "insidetextfont": {"color": {"colour": "ink" if mark.colour == "noise" else "surface"}},
        }  # fmt: skip
    marker: Json = {"color": colour, "size": mark.size, "opacity": mark.opacity, "symbol": mark.shape or "circle"}
    if mark.hollow:
        fills = [{"colour": "surface" if hollow else mark.colour} for hollow in mark.hollow]
        marker |= {"color": fills, "line": {"color": colour, "width": 1.8}}
    if mark.half_widths:
        trace["error_y" if mark.upright else "error_x"] = {
            "type": "data", "array": mark.half_widths, "color": colour, "thickness": 1.6, "width": 4,
        }  # fmt: skip
    return trace | {
        "type": "scatter", "x": arrays.keep(mark.x), "y": arrays.keep(mark.y), "marker": marker,
        "mode": "+".join(part for part, there in (("lines", mark.width), ("markers", mark.shape)) if there),
        "line": {"color": colour, "width": mark.width, "dash": mark.dash},
        "hovertemplate": "%{text}" if mark.words else "%{y:.5g}" if mark.width else "%{x:.4g}, %{y:.4g}",
    }  # fmt: skip


def _heat(mark: Heat) -> Json:
    rows_of, columns_of = (list(range(count)) for count in mark.matrix.shape)
    low, high = mark.limits
    rows = [[round(value, mark.digits) for value in row] for row in mark.matrix.tolist()]
    return {
        "type": "heatmap", "x": columns_of, "y": rows_of, "z": rows, "zmin": low, "zmax": high,
        "texttemplate": f"%{{z:.{mark.digits}f}}" if mark.written else "",
        "hovertemplate": f"%{{z:.{mark.digits}f}}<extra></extra>",
    }  # fmt: skip


def _axis(axis: Axis, which: str) -> Json:
    drawn: Json = {"title": {"text": _literal(axis.label)}}
    if axis.logarithmic:
        drawn |= {"type": "log", "dtick": 1}
    if axis.limits:
        drawn["range"] = list(axis.limits)
    if axis.ticks:
        places, names = zip(*axis.ticks, strict=True)
        drawn |= {
            "tickvals": list(places), "ticktext": [*map(_literal, names)], "zeroline": False,
            "range": sorted(axis.ends, reverse=which == "y"), "tickfont": {"color": {"colour": "ink"}}, "tickangle": 0,
            "showgrid": False,
        }  # fmt: skip
    return drawn
