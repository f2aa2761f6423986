# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a picture shows: data, labels with units, words and colours. How it is drawn is the renderers' affair.

Colours have names by what they stand for; people with any colour vision can tell them apart. The hues are those of
Okabe and Ito (Color Universal Design, 2008), lighter ones on a dark ground; models also differ by the dash of their
lines and trials by the shape of their marks.
"""

import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cdp_ident.arrays import Array

Colour = Literal[
    "ink", "quiet", "grid", "surface", "before", "after", "noise", "held_out",
    "series1", "series2", "series3", "series4", "series5", "series6",
]  # fmt: skip
Dash = Literal["solid", "dash", "dot"]

_ON_GROUNDS: dict[Colour, tuple[str, str]] = {
    "ink": ("#1b1f24", "#e6edf3"),
    "quiet": ("#57606a", "#9ea7b3"),
    "grid": ("#d8dee4", "#30363d"),
    "surface": ("#ffffff", "#161b22"),
    "before": ("#d55e00", "#f0883e"),
    "after": ("#0072b2", "#56b4e9"),
    "noise": ("#8c959f", "#7d8590"),
    "held_out": ("#fff3cf", "#2f2a1c"),
    "series1": ("#0072b2", "#56b4e9"),
    "series2": ("#d55e00", "#f0883e"),
    "series3": ("#009e73", "#2fc49a"),
    "series4": ("#cc79a7", "#e3a1c8"),
    "series5": ("#b58900", "#f0e442"),
    "series6": ("#4f9fd0", "#8fb8d8"),
}
LIGHT, DARK = ({name: pair[ground] for name, pair in _ON_GROUNDS.items()} for ground in range(2))
SERIES: tuple[Colour, ...] = ("series1", "series2", "series3", "series4", "series5", "series6")
SHAPES = {"circle": "o", "square": "s", "diamond": "D", "triangle-up": "^", "x": "X", "star": "*"}
"""Shapes of marks as plotly names them, and as matplotlib does."""
_LABEL_WIDTH = 22
"""Characters in a line of a name beside an axis: two thirds of a phone remain beside it."""
_MOST_WRITTEN = 9
"""Columns of a square whose numbers still fit in on a phone."""


@dataclass(frozen=True)
class Line:
    """Points with a line through them, a mark at each, or an interval about each.

    Where y is not a number a line is interrupted. Points may hide each other.
    """

    label: str
    colour: Colour
    x: Array
    y: Array
    width: float = 1.5
    """Of the line; 0 for none."""
    dash: Dash = "solid"
    shape: str = ""
    """Of the marks, as plotly.js names it; empty for none. One that is `-open` lets show what lies below."""
    size: float = 6.0
    """Diameter of the marks in points."""
    opacity: float = 1.0
    hollow: Sequence[bool] = ()
    """Which marks are only outlined, if any are."""
    half_widths: Sequence[float] = ()
    """Of the intervals, along x; not finite for one without ends."""
    upright: bool = False
    """Whether intervals are along y."""
    words: Sequence[str] = ()
    """What is said of each point; its coordinates, if nothing is."""


@dataclass(frozen=True)
class Bars:
    """Horizontal bars from zero to x, each with its length in words."""

    label: str
    colour: Colour
    x: Sequence[float]
    y: Sequence[float]
    words: Sequence[str]
    thickness: float = 0.7


@dataclass(frozen=True)
class Heat:
    """A field of numbers, coloured between two limits; halfway between them it has the ground's colour."""

    matrix: Array
    limits: tuple[float, float] = (-1.0, 1.0)
    digits: int = 2
    """Behind the point."""
    label: str = ""

    @property
    def written(self) -> bool:
        """Whether there is room for the numbers themselves."""
        return self.matrix.shape[1] <= _MOST_WRITTEN


Mark = Line | Bars | Heat


@dataclass(frozen=True)
class Axis:
    """What is along an axis, with its unit."""

    label: str = ""
    logarithmic: bool = False
    ticks: Sequence[tuple[float, str]] = ()
    """Places with names, the first on top; where there are none, places are numbers."""
    limits: tuple[float, float] | None = None

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of an axis whose places have names, with room for what is around the first and the last."""
        places = [place for place, _ in self.ticks]
        return min(places) - 0.6, max(places) + 0.6

    def name_at(self, place: float) -> str:
        """Return the name that is nearest to a place; empty where places are numbers."""
        return min(self.ticks, key=lambda tick: abs(tick[0] - place), default=(place, ""))[1]


def series(index: int) -> tuple[Colour, str]:
    """Return colour and shape of one of several trials or runs."""
    return SERIES[index % len(SERIES)], list(SHAPES)[index % len(SHAPES)]


def named(names: Iterable[str]) -> Axis:
    """Return an axis with names at the places 0, 1 and so on."""
    return Axis(ticks=[(float(place), name) for place, name in enumerate(names)])


def wrapped(name: str) -> str:
    """Break a name that stands beside an axis into lines."""
    return "\n".join(textwrap.wrap(name, _LABEL_WIDTH))


def level(label: str, colour: Colour, value: float, names: Axis) -> Line:
    """Return a vertical line across a panel with named places, that others are compared with."""
    return Line(label, colour, np.full(2, value), np.array(names.ends), 2.0, "dot", words=(f"{value:.4g}",) * 2)


def beside(index: int, count: int, apart: float, places: int) -> list[float]:
    """Return where the marks of one of several models or runs are, so far from the next one's, at each named place."""
    return [place + apart * (index - (count - 1) / 2) for place in range(places)]


@dataclass(frozen=True)
class Panel:
    """One coordinate system of a figure."""

    x: Axis
    y: Axis
    marks: Sequence[Mark]
    title: str = ""
    height: float = 200.0
    """In pixels on a page; proportional elsewhere."""
    held_out: Sequence[tuple[float, float]] = ()
    """Stretches of x that were held out."""


@dataclass(frozen=True)
class Figure:
    """Panels one below the other."""

    name: str
    """Name of its files; letters, digits, dots, hyphens and underscores."""
    title: str
    caption: str
    """How to read it."""
    panels: Sequence[Panel]
    shared_x: bool = False
    """Whether all panels have the x axis of the last one."""

    @property
    def alternative(self) -> str:
        """What it shows, for those who cannot see it."""
        return " ".join([f"{self.title}.", *(f"{_in_words(panel)}." for panel in self.panels)])

    def legend(self) -> list[tuple[str, Colour, str]]:
        """Return label, colour and kind of mark of everything that has a name, each once."""
        entries: dict[str, tuple[str, Colour, str]] = {}
        for panel in self.panels:
            for mark in panel.marks:
                if not isinstance(mark, Heat):
                    entries.setdefault(mark.label, (mark.label, mark.colour, _kind(mark)))
            if panel.held_out:
                entries.setdefault("held out", ("held out", "held_out", "span"))
        return list(entries.values())


def _in_words(panel: Panel) -> str:
    """Say of each mark what it says itself, by the names along y, or else between what it is."""
    said: dict[str, str] = {}
    for mark in panel.marks:
        if isinstance(mark, Heat) or not mark.words:
            numbers = mark.matrix if isinstance(mark, Heat) else np.asarray(mark.y)
            known = numbers[np.isfinite(numbers)]
            words = f"{known.min():.3g} to {known.max():.3g}" if len(known) else "nothing"
        elif isinstance(mark, Bars) or mark.shape:
            named_words = zip(map(panel.y.name_at, mark.y), mark.words, strict=True)
            words = ", ".join(f"{name} {word}".strip() for name, word in named_words)
        else:
            words = mark.words[0]
        said.setdefault(mark.label, words)
    title = panel.title or panel.y.label or panel.x.label
    return f"{title}: {'; '.join(f'{label} {words}'.strip() for label, words in said.items())}".removeprefix(": ")


def _kind(mark: Line | Bars) -> str:
    if isinstance(mark, Bars):
        return "bars"
    if not mark.width:
        return mark.shape
    return "thin" if mark.width < 1.0 else mark.dash
