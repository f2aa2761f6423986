"""The colours of pictures and page by what they stand for; people with any colour vision can tell them apart.

The hues are those of Okabe and Ito (Color Universal Design, 2008), lighter ones on a dark ground; models also differ by
the dash of their lines and trials by the shape of their marks.
"""

from typing import Literal

Colour = Literal[
    "ink", "quiet", "grid", "surface", "before", "after", "noise", "held_out",
    "series1", "series2", "series3", "series4", "series5", "series6",
]  # fmt: skip

LIGHT: dict[Colour, str] = {
    "ink": "#1b1f24",
    "quiet": "#57606a",
    "grid": "#d8dee4",
    "surface": "#ffffff",
    "before": "#d55e00",
    "after": "#0072b2",
    "noise": "#8c959f",
    "held_out": "#fff3cf",
    "series1": "#0072b2",
    "series2": "#d55e00",
    "series3": "#009e73",
    "series4": "#cc79a7",
    "series5": "#b58900",
    "series6": "#4f9fd0",
}

DARK: dict[Colour, str] = {
    "ink": "#e6edf3",
    "quiet": "#9ea7b3",
    "grid": "#30363d",
    "surface": "#161b22",
    "before": "#f0883e",
    "after": "#56b4e9",
    "noise": "#7d8590",
    "held_out": "#2f2a1c",
    "series1": "#56b4e9",
    "series2": "#f0883e",
    "series3": "#2fc49a",
    "series4": "#e3a1c8",
    "series5": "#f0e442",
    "series6": "#8fb8d8",
}

SERIES: tuple[Colour, ...] = ("series1", "series2", "series3", "series4", "series5", "series6")
SHAPES = ("circle", "square", "diamond", "triangle", "cross", "star")


def series(index: int) -> tuple[Colour, str]:
    """Return colour and shape of one of several trials or runs."""
    return SERIES[index % len(SERIES)], SHAPES[index % len(SHAPES)]
