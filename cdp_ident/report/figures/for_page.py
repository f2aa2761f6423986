# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draws figures for a page: as plotly.js takes them, but for arrays, colours and style, which the page puts in.

An array stands as `{"array": name}` and is kept once however many figures show it; a colour stands as
`{"colour": name}`, because it depends on the theme. What all figures have alike is in `templates/charts.js`.
"""

import base64
import hashlib
import html
import math
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.report.figures.description import Axis, Bars, Figure, Heat, Mark
from cdp_ident.report.figures.palette import Colour

Json = dict[str, Any]

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
    return {"data": data, "layout": layout}


def _colour(name: Colour) -> Json:
    return {"colour": name}


def _literal(text: str) -> str:
    """Return text that plotly.js shows as it is, where it would take a part of it for markup."""
    return html.escape(text, quote=False).replace("\n", "<br>")


def _trace(mark: Mark, arrays: Arrays) -> Json:
    if isinstance(mark, Heat):
        return _heat(mark)
    colour = _colour(mark.colour)
    trace: Json = {"name": _literal(mark.label.partition(":")[0]), "meta": mark.label}
    trace["text"] = [_literal(words) for words in mark.words]
    if isinstance(mark, Bars):
        return trace | {
            "type": "bar", "x": _finite(mark.lengths), "y": list(mark.positions), "width": mark.thickness,
            "marker": {"color": colour},
            "insidetextfont": {"color": _colour("ink" if mark.colour == "noise" else "surface")},
        }  # fmt: skip
    marker: Json = {"color": colour, "size": mark.size, "opacity": mark.opacity, "symbol": mark.shape or "circle"}
    if mark.hollow:
        fills = [_colour("surface" if hollow else mark.colour) for hollow in mark.hollow]
        marker |= {"color": fills, "line": {"color": colour, "width": 1.8}}
    if mark.half_widths:
        trace["error_y" if mark.upright else "error_x"] = {
            "type": "data", "array": _finite(mark.half_widths), "color": colour, "thickness": 1.6, "width": 4,
        }  # fmt: skip
    return trace | {
        "type": "scatter", "x": arrays.keep(mark.x), "y": arrays.keep(mark.y), "marker": marker,
        "mode": "+".join(part for part, there in (("lines", mark.width), ("markers", mark.shape)) if there),
        "line": {"color": colour, "width": mark.width, "dash": mark.dash},
        "hovertemplate": "%{text}" if mark.words else "%{y:.5g}" if mark.width else "%{x:.4g}, %{y:.4g}",
    }  # fmt: skip


def _finite(values: Sequence[float]) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values]


def _heat(mark: Heat) -> Json:
    rows_of, columns_of = (list(range(count)) for count in mark.matrix.shape)
    low, high = mark.limits
    rows = [[round(float(v), mark.digits) if math.isfinite(v) else None for v in row] for row in mark.matrix]
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
            "range": sorted(axis.ends, reverse=which == "y"), "tickfont": {"color": _colour("ink")}, "tickangle": 0,
            "showgrid": False,
        }  # fmt: skip
    return drawn
