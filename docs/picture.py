# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draws the README's picture from a report of identify.

    python docs/picture.py REPORT_FOLDER docs/measured_swing.svg

The folder is one that `identify` wrote: its report.json and curves.npz are read. The first trial is shown.
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from cdp_ident.report.curves import read_curves  # noqa: E402
from cdp_ident.report.folder import CURVES, REPORT  # noqa: E402
from cdp_ident.report.report_file import read_report  # noqa: E402

MEASURED, BEFORE, AFTER = "#808a94", "#d55e00", "#3a8fc4"
"""On a white page and on a dark one."""
LONGEST = 20.0
"""How much of the trial is shown [s]."""
_POINTS = 700
_SETTINGS = {
    "font.size": 9,
    "text.color": MEASURED,
    "axes.edgecolor": MEASURED,
    "axes.labelcolor": MEASURED,
    "axes.facecolor": "none",
    "axes.linewidth": 0.6,
    "xtick.color": MEASURED,
    "ytick.color": MEASURED,
    "svg.hashsalt": "cdp_ident",
    "svg.fonttype": "none",
}


def draw(folder: Path, out: Path) -> None:
    """Draw a report's first trial: one simulation of it, and what is left over windows, before and after."""
    report = read_report(folder / REPORT)
    trial = read_curves(folder / CURVES, len(report["trials"]), len(report["effects"])).trials[0]
    shown = np.flatnonzero(trial.time <= LONGEST)
    every = shown[:: max(1, len(shown) // _POINTS)]
    time = trial.time[every]
    error = {key: 1e3 * report[key]["error"]["holdout"]["rmse_rad"] for key in ("before", "after")}
    with matplotlib.rc_context(_SETTINGS):
        figure = Figure(figsize=(8.2, 4.2), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.1, 1.0])
        above.plot(time, trial.measured[every, 1], color=MEASURED, linewidth=3.5, alpha=0.6, label="measured")
        above.plot(time, trial.run_before[every, 1], color=BEFORE, linewidth=1.0, label="the paper's model, fitted")
        above.plot(time, trial.run_after[every, 1], color=AFTER, linewidth=1.0, label="with the effects found")
        low, high = trial.measured[shown, 1].min(), trial.measured[shown, 1].max()
        above.set_ylim(low - 0.3, high + 0.3)
        _finish(above, "outer rod [rad]", "One simulation of the whole swing")
        figure.legend(loc="outside upper center", ncols=3, frameon=False)
        for colour, key in ((BEFORE, "before"), (AFTER, "after")):
            left = 1e3 * (trial.measured - getattr(trial, key))[every, 1]
            below.plot(time, left, color=colour, linewidth=0.8)
        _finish(
            below,
            "difference [mrad]",
            f"Over windows, each from its own start; held out: {error['before']:.2f} and {error['after']:.2f} mrad",
        )
        below.set_xlabel("time [s]")
        FigureCanvasSVG(figure).print_figure(
            out, format="svg", facecolor="none", metadata={"Date": None, "Creator": None}
        )


def _finish(axes: Axes, label: str, title: str) -> None:
    axes.set_ylabel(label)
    axes.set_title(title, loc="left", fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.argv[2]))
