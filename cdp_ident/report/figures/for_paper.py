# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draws figures as files for a paper: PNG, and SVG, whose text stays text."""

import io
import math
from dataclasses import replace

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from cdp_ident.report.figures.description import LIGHT, SHAPES, Axis, Colour, Figure, Heat, Line, Panel

_WIDTH = 6.5
"""Inches: the width of a page's text."""
_PIXELS = 96.0
"""Of a panel's height in an inch."""
_LEGEND_ROW, _LEGEND_LETTERS = 0.22, 100
"""Height of a row [inches], and letters that it has room for; an entry's line takes eight."""
_RESOLUTION = 150.0
_DASHES: dict[str, tuple[float, ...]] = {"solid": (), "dash": (4, 2), "dot": (2, 1.5)}
_BEHIND_WORDS = {"facecolor": LIGHT["surface"], "linewidth": 0, "pad": 0.6}
_SETTINGS = {
    **dict.fromkeys(("axes.edgecolor", "xtick.color", "ytick.color"), LIGHT["quiet"]),
    **dict.fromkeys(("axes.labelcolor", "text.color", "xtick.labelcolor", "ytick.labelcolor"), LIGHT["ink"]),
    **dict.fromkeys(("figure.autolayout", "figure.constrained_layout.use"), False),
    "font.size": 8.5,
    "font.family": "sans-serif",
    "axes.linewidth": 0.6,
    "svg.fonttype": "none",
    "svg.hashsalt": "cdp_ident",
    "path.simplify": True,
}


def png_and_svg(figure: Figure) -> tuple[bytes, bytes]:
    """Return a figure as a PNG and as an SVG file."""
    with matplotlib.rc_context(_SETTINGS):
        canvas = _drawn(figure)
        png, svg = io.BytesIO(), io.BytesIO()
        FigureCanvasAgg(canvas).print_figure(png, format="png", dpi=_RESOLUTION, metadata={"Software": None})
        FigureCanvasSVG(canvas).print_figure(svg, format="svg", metadata={"Date": None, "Creator": None})
    return png.getvalue(), svg.getvalue()


def _drawn(figure: Figure) -> Canvas:
    heights = [panel.height for panel in figure.panels]
    legend = figure.legend()
    columns = max(1, min(len(legend), _LEGEND_LETTERS // (max((len(label) for label, _, _ in legend), default=0) + 8)))
    below = _LEGEND_ROW * math.ceil(len(legend) / columns)
    height = (sum(heights) + 40) / _PIXELS + below
    # The legend's place is kept by hand: matplotlib has had "outside lower center" since 3.7, Ubuntu 24.04 has 3.6.
    layout = ConstrainedLayoutEngine(rect=(0.0, below / height, 1.0, 1.0 - below / height))
    canvas = Canvas(figsize=(_WIDTH, height), layout=layout)
    axes = canvas.subplots(len(heights), 1, sharex=figure.shared_x, height_ratios=heights, squeeze=False)[:, 0]
    for index, (panel, ax) in enumerate(zip(figure.panels, axes, strict=True)):
        _draw(panel, ax, figure.shared_x and index < len(heights) - 1)
    canvas.suptitle(_literal(figure.title), fontsize=10, fontweight="bold")
    if legend:
        handles = [_handle(*entry) for entry in legend]
        canvas.legend(handles=handles, loc="lower center", ncols=columns, frameon=False)
    FigureCanvasAgg(canvas)
    layout.execute(canvas)
    # Not "none", which stands for an engine all the same: to please it, each file would be drawn twice.
    canvas.set_layout_engine(None)
    for ax in axes:
        # The last digits of a layout are chance's, and in the names of an SVG's parts.
        ax.set_position([round(bound, 6) for bound in ax.get_position().bounds])
    return canvas


def _draw(panel: Panel, ax: Axes, hides_x: bool) -> None:
    ax.grid(True, color=LIGHT["grid"], linewidth=0.5)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)
    for begin, end in panel.held_out:
        ax.axvspan(begin, end, color=LIGHT["held_out"], linewidth=0, zorder=0)
    for mark in panel.marks:
        if isinstance(mark, Line):
            _line(mark, ax)
        elif isinstance(mark, Heat):
            _heat(mark, ax)
        else:
            bars = ax.barh(mark.y, mark.x, mark.thickness, color=LIGHT[mark.colour])
            ax.bar_label(bars, [_literal(words) for words in mark.words], padding=3, fontsize=8, bbox=_BEHIND_WORDS)
            ax.margins(x=0.1)
    if panel.title:
        ax.set_title(_literal(panel.title), fontsize=9, loc="left")
    _axis(replace(panel.x, label="") if hides_x else panel.x, ax, "x")
    _axis(panel.y, ax, "y")


def _axis(axis: Axis, ax: Axes, which: str) -> None:
    getattr(ax, f"set_{which}label")(_literal(axis.label))
    if axis.logarithmic:
        getattr(ax, f"set_{which}scale")("log")
    if axis.limits:
        getattr(ax, f"set_{which}lim")(*axis.limits)
    if axis.ticks:
        places, names = zip(*axis.ticks, strict=True)
        getattr(ax, f"set_{which}ticks")(places, [_literal(name) for name in names], fontsize=7.5, linespacing=0.95)
        getattr(ax, f"set_{which}lim")(*sorted(axis.ends, reverse=which == "y"))


def _line(mark: Line, ax: Axes) -> None:
    colour, shape = LIGHT[mark.colour], mark.shape.removesuffix("-open")
    if mark.half_widths:
        halves = np.where(np.isfinite(mark.half_widths), mark.half_widths, np.nan)
        y, x = (halves, None) if mark.upright else (None, halves)
        ax.errorbar(mark.x, mark.y, y, x, fmt="none", ecolor=colour, elinewidth=1.1, capsize=2)
    hollow = np.array(mark.hollow or [False] * len(mark.x))
    for is_hollow in np.unique(hollow):
        ax.plot(
            mark.x[hollow == is_hollow], mark.y[hollow == is_hollow], color=colour, alpha=mark.opacity,
            linewidth=0.7 * mark.width, linestyle=(0, _DASHES[mark.dash]) if mark.width else "none",
            marker=SHAPES.get(shape), markersize=0.6 * mark.size, fillstyle="full" if shape == mark.shape else "none",
            markeredgewidth=1.0 if mark.hollow or shape != mark.shape else 0.0,
            markerfacecolor=LIGHT["surface"] if is_hollow else colour,
            rasterized=mark.opacity < 1.0,  # such clouds have many points
        )  # fmt: skip


def _heat(mark: Heat, ax: Axes) -> None:
    colours = LinearSegmentedColormap.from_list("correlation", [LIGHT["after"], LIGHT["surface"], LIGHT["before"]])
    ax.imshow(mark.matrix, cmap=colours, vmin=mark.limits[0], vmax=mark.limits[1], aspect="auto")
    ax.grid(False)
    for (row, column), value in np.ndenumerate(mark.matrix) if mark.written else ():
        words = f"{value:.{mark.digits}f}" if math.isfinite(value) else "?"
        ax.text(column, row, words, ha="center", va="center", fontsize=8)


def _handle(label: str, colour: Colour, kind: str) -> Line2D | Patch:
    label = _literal(label)
    if kind in ("bars", "span"):
        return Patch(color=LIGHT[colour], label=label)
    marker, is_open = SHAPES.get(kind.removesuffix("-open"), ""), kind.endswith("-open")
    return Line2D(
        [], [], color=LIGHT[colour], marker=marker, markersize=4.5, label=label,
        linestyle="none" if marker else (0, _DASHES.get(kind, ())), linewidth=0.5 if kind == "thin" else 1.5,
        fillstyle="none" if is_open else "full",
    )  # fmt: skip


def _literal(text: str) -> str:
    """Return text that matplotlib prints as it is, where a pair of dollar signs would be taken for a formula."""
    return text.replace("$", r"\$")
