# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a picture shows: data, labels with units, words and colours. How it is drawn is the renderers' affair."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.report.figures.palette import Colour

Array = npt.NDArray[np.float64]


_MOST_WRITTEN = 9
"""Columns of a square whose numbers still fit in on a phone."""


@dataclass(frozen=True)
class Line:
    """A curve; where y is not a number it is interrupted."""

    label: str
    colour: Colour
    x: Array
    y: Array
    width: float = 1.5
    dashed: bool = False
    marked: bool = False
    """Whether each point is marked."""


@dataclass(frozen=True)
class Dots:
    """A cloud of points, which may hide each other."""

    label: str
    colour: Colour
    x: Array
    y: Array
    size: float = 4.0
    """Diameter in points."""
    opacity: float = 0.35
    hollow: bool = False
    """Whether they are rings, through which what lies below can be read."""


@dataclass(frozen=True)
class Bars:
    """Horizontal bars from zero, each with its length in words."""

    label: str
    colour: Colour
    positions: Sequence[float]
    lengths: Sequence[float]
    words: Sequence[str]
    thickness: float = 0.7


@dataclass(frozen=True)
class Intervals:
    """Values with an interval to either side; hollow where the trials do not determine them."""

    label: str
    colour: Colour
    positions: Sequence[float]
    values: Sequence[float]
    half_widths: Sequence[float]
    hollow: Sequence[bool]
    words: Sequence[str]
    shape: str = "circle"
    upright: bool = False
    """Whether the values are along y, and the positions along x."""


@dataclass(frozen=True)
class Heat:
    """A field of numbers, coloured between two limits; halfway between them it has the ground's colour."""

    matrix: Array
    limits: tuple[float, float] = (-1.0, 1.0)
    digits: int = 2
    """Behind the point."""

    @property
    def written(self) -> bool:
        """Whether there is room for the numbers themselves."""
        return self.matrix.shape[1] <= _MOST_WRITTEN


@dataclass(frozen=True)
class Level:
    """A vertical line across a panel with named places, that others are compared with."""

    label: str
    colour: Colour
    value: float


Mark = Line | Dots | Bars | Intervals | Heat | Level


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


def named(names: Iterable[str]) -> Axis:
    """Return an axis with names at the places 0, 1 and so on."""
    return Axis(ticks=[(float(place), name) for place, name in enumerate(names)])


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
    alternative: str
    """What it shows, for those who cannot see it."""
    panels: Sequence[Panel]
    shared_x: bool = False
    """Whether all panels have the x axis of the last one."""

    def legend(self) -> list[tuple[str, Colour, str]]:
        """Return label, colour and kind of mark of everything that has a name, each once."""
        entries: dict[str, tuple[str, Colour, str]] = {}
        for panel in self.panels:
            for mark in panel.marks:
                if not isinstance(mark, Heat):
                    entries.setdefault(mark.label, (mark.label, mark.colour, _kind(mark)))
            if panel.held_out:
                entries.setdefault(HELD_OUT, (HELD_OUT, "held_out", "span"))
        return list(entries.values())


HELD_OUT = "held out"


def _kind(mark: Line | Dots | Bars | Intervals | Level) -> str:
    if isinstance(mark, Line):
        return "dashed" if mark.dashed else "thin" if mark.width < 1.0 else "line"
    if isinstance(mark, Dots) and mark.hollow:
        return "ring"
    return mark.shape if isinstance(mark, Intervals) else type(mark).__name__.lower()
