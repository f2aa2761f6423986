"""Pictures of the gallery: what the paper's model leaves when one effect is missing, and what the found one leaves."""

import io
from collections.abc import Mapping
from dataclasses import dataclass

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

COLOURS = {"before": "#d55e00", "after": "#3a8fc4"}
"""Of Okabe and Ito, light enough for a dark page and dark enough for a light one."""
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
    """The curves of a picture; each with the paper's model (`before`) and with what was found (`after`)."""

    joint: str
    residuals: Mapping[str, tuple[Array, Array]]
    """Times (n,) [s], and measured less simulated theta1, theta2 (n, 2) [mrad]."""
    torques: Mapping[str, tuple[Array, Array, Array]] | None
    """The joint's speed [rad/s], its angle [rad], and the missing torque [mN m], (n,) each; None where what is missing
    is no torque that lasts."""


def picture(shown: Shown) -> bytes:
    """Return the picture as an SVG file without a background."""
    with matplotlib.rc_context(_SETTINGS):
        figure = Figure(figsize=(8.2, 1.9), layout="constrained")
        left, middle, right = figure.subplots(1, 3, width_ratios=[1.6, 1.0, 1.0])
        for name, (time, angles) in shown.residuals.items():
            every = max(1, len(time) // _MOST)
            left.plot(time[::every], angles[::every, 0], color=COLOURS[name], linewidth=0.6, alpha=0.6)
            left.plot(time[::every], angles[::every, 1], color=COLOURS[name], linewidth=0.8)
        _label(left, "time [s]", "residual [mrad]")
        for axes, column, unit in ((middle, 0, "speed, {} joint [rad/s]"), (right, 1, "angle, {} joint [rad]")):
            if shown.torques is None:
                axes.remove()
                continue
            for name, curves in shown.torques.items():
                axes.plot(*_mean(curves[column], curves[2]), color=COLOURS[name], linewidth=1.2)
            _label(axes, unit.format(shown.joint), "missing torque [mN m]")
        stream = io.BytesIO()
        FigureCanvasSVG(figure).print_figure(
            stream, format="svg", facecolor="none", metadata={"Date": None, "Creator": None}
        )
    return stream.getvalue()


def _label(axes: Axes, x: str, y: str) -> None:
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
