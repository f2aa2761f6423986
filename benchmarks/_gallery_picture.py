# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pictures of the gallery: what the paper's model leaves when one effect is missing."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

COLOUR = "#d55e00"
"""Of Okabe and Ito, seen on a light page and on a dark one."""
GREY = "#808a94"
_SETTINGS = {
    "font.size": 7.5,
    "text.color": GREY,
    "axes.edgecolor": GREY,
    "axes.labelcolor": GREY,
    "axes.linewidth": 0.6,
    "axes.facecolor": "none",
    "xtick.color": GREY,
    "ytick.color": GREY,
    "svg.hashsalt": "cdp_ident",
    "svg.fonttype": "none",
}
_MOST = 400
"""Points of a curve in time."""
_BINS = 20


@dataclass(frozen=True)
class Shown:
    """The curves of a picture: what the paper's model leaves."""

    joint: str
    noise: float
    """Of the measured angles [mrad]."""
    windows: Sequence[tuple[Array, Array]]
    """Of each window, times (n,) [s], and measured less simulated theta1, theta2 (n, 2) [mrad]."""
    torque: tuple[Array, Array, Array] | None
    """The joint's speed [rad/s], its angle [rad], and the missing torque [mN m], (n,) each; None where what is missing
    is no torque that lasts."""


def picture(shown: Shown) -> bytes:
    """Return the picture as an SVG file without a background."""
    # Only who draws waits for what draws to be loaded.
    import matplotlib  # noqa: PLC0415
    from matplotlib.backends.backend_svg import FigureCanvasSVG  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    with matplotlib.rc_context(_SETTINGS):
        figure = Figure(figsize=(8.2, 1.9), layout="constrained")
        left, middle, right = figure.subplots(1, 3, width_ratios=[1.6, 1.0, 1.0])
        left.axhspan(-shown.noise, shown.noise, color=GREY, alpha=0.35, linewidth=0)
        every = max(1, sum(len(time) for time, _ in shown.windows) // _MOST)
        for time, angles in shown.windows:
            left.plot(time[::every], angles[::every, 0], color=COLOUR, linewidth=0.7, alpha=0.5)
            left.plot(time[::every], angles[::every, 1], color=COLOUR, linewidth=1.0)
        _label(left, "time [s]", "residual [mrad]")
        for axes, column, unit in ((middle, 0, "speed, {} joint [rad/s]"), (right, 1, "angle, {} joint [rad]")):
            if shown.torque is None:
                axes.remove()
                continue
            axes.plot(*_mean(shown.torque[column], shown.torque[2]), color=COLOUR, linewidth=1.2)
            _label(axes, unit.format(shown.joint), "missing torque [mN m]")
        stream = io.BytesIO()
        FigureCanvasSVG(figure).print_figure(
            stream, format="svg", facecolor="none", metadata={"Date": None, "Creator": None}
        )
    return stream.getvalue()


def _label(axes: "Axes", x: str, y: str) -> None:
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.spines[["top", "right"]].set_visible(False)
    axes.axhline(0.0, color=GREY, linewidth=0.4)


def _mean(x: Array, y: Array) -> tuple[Array, Array]:
    """Return the mean in bins of equal counts."""
    edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, _BINS + 1)))
    places = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)
    counts = np.maximum(np.bincount(places), 1)
    return np.bincount(places, weights=x) / counts, np.bincount(places, weights=y) / counts
