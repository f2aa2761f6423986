# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The colours of pictures and page by what they stand for; people with any colour vision can tell them apart.

The hues are those of Okabe and Ito (Color Universal Design, 2008), lighter ones on a dark ground; models also differ by
the dash of their lines and trials by the shape of their marks.
"""

from typing import Literal

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


def series(index: int) -> tuple[Colour, str]:
    """Return colour and shape of one of several trials or runs."""
    return SERIES[index % len(SERIES)], list(SHAPES)[index % len(SHAPES)]
