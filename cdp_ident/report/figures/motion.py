# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Angles over time, measured and simulated."""

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cdp_ident.report.curves import NO_WINDOW, Array, Curves, TrialCurves
from cdp_ident.report.figures.description import Axis, Figure, Line, Panel
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import Model, models, role_words

MOST_SAMPLES = 10_000
"""Of all trials together: a page with more has over 2 MB. Of longer trials every second, third … sample is shown."""
_ANGLES = ("θ1", "θ2")
TIME = Axis("time since the rods swing freely [s]")


def shown_samples(curves: Curves) -> slice:
    """Return which samples of each trial are shown."""
    return slice(None, None, max(1, -(-sum(len(trial.time) for trial in curves.trials) // MOST_SAMPLES)))


def angles(report: Section, curves: Curves) -> Iterator[Figure]:
    """Yield a figure for each trial: angles over windows, and what is left of them beneath on the same axis."""
    caption = (
        "Top: measured and simulated over windows of {window:.2g} s, whose initial states are fitted. Below: measured "
        "less simulated.{thinned}"
    )
    return _of_trials(report, curves, "angles", "Angles", caption, "")


def continuous_runs(report: Section, curves: Curves) -> Iterator[Figure]:
    """Yield the paper's contrast curves and angular errors of each trial, from one continuous run (Eq. 10)."""
    caption = (
        "One simulation of the whole trial from its fitted initial state (Eq. 10). Where the motion is chaotic, no "
        "model follows it for long.{thinned} As the paper's Figs. 3, 4, 8 and 10 to 12."
    )
    return _of_trials(report, curves, "contrast", "Contrast curves and angular errors", caption, "run_")


def _of_trials(report: Section, curves: Curves, name: str, title: str, caption: str, kind: str) -> Iterator[Figure]:
    """Yield a figure for each trial, with the curves of a kind."""
    every = shown_samples(curves)
    thinned = f" One of {every.step} samples is shown." if every.step > 1 else ""
    for index, (trial, curve) in enumerate(zip(report["trials"], curves.trials, strict=True), start=1):
        window = float(np.ptp(curve.time)) / max(int(curve.window.max()) + 1, 1)
        yield measured_and_simulated(
            f"{name}_{index}_{file_name(trial['name'])}",
            f"{title} of {trial['name']} ({role_words(trial)})",
            caption.format(window=window, thinned=thinned),
            curve.time[every],
            curve.measured[every],
            {model: getattr(curve, kind + model.key)[every] for model in models(report)},
            _held_out(curve),
        )


def file_name(name: str) -> str:
    """Return a trial's name as a part of a file's name."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name)[:40]


def measured_and_simulated(
    name: str,
    title: str,
    caption: str,
    time: Array,
    measured: Array,
    simulated: Mapping[Model, Array],
    held_out: Sequence[tuple[float, float]] = (),
) -> Figure:
    """Return the figure of a motion: angles (n, 2) measured and simulated [rad], and beneath what is left of them."""
    left = {model: measured - angles for model, angles in simulated.items()}
    above, below = [], []
    for column, angle in enumerate(_ANGLES):
        lines = [
            Line("measured", "ink", time, measured[:, column], width=2.5),
            *(
                Line(model.label, model.key, time, angles[:, column], dash=model.dash)
                for model, angles in simulated.items()
            ),
        ]
        errors = [Line(model.label, model.key, time, 1e3 * error[:, column], 1.2) for model, error in left.items()]
        above.append(Panel(TIME, Axis(f"{angle} [rad]"), lines, height=190, held_out=held_out))
        below.append(Panel(TIME, Axis(f"error of {angle} [mrad]"), errors, height=150, held_out=held_out))
    said = (
        f"{title}, over {time[-1]:.3g} s. Measured less simulated: {'; '.join(map(_rms_words, left, left.values()))}."
    )
    return Figure(name, title, caption, said, [*above, *below], shared_x=True)


def _rms_words(model: Model, left: Array) -> str:
    known = left[np.isfinite(left).all(axis=1)]
    if not len(known):
        return f"{model.label}: diverged"
    rms = 1e3 * np.sqrt(np.mean(known**2, axis=0))
    return f"{model.label}: {rms[0]:.3g} mrad rms in θ1 and {rms[1]:.3g} mrad in θ2"


def _held_out(curve: TrialCurves) -> list[tuple[float, float]]:
    """Return the windows that were held out, where others of the trial were not."""
    if curve.held_out[curve.window != NO_WINDOW].all():
        return []
    windows = np.unique(curve.window[curve.held_out])
    return [(float(t[0]), float(t[-1])) for t in (curve.time[curve.window == window] for window in windows)]
