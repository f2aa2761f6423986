"""Angles over time, measured and simulated."""

import re
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from cdp_ident.report.curves import NO_WINDOW, Curves, TrialCurves
from cdp_ident.report.figures.description import Axis, Figure, Line, Panel, Place
from cdp_ident.report.figures.models import Model, models
from cdp_ident.report.schema import Section

Array = npt.NDArray[np.float64]

MOST_SAMPLES = 20_000
"""Of all trials together: a page with more opens slowly. Of longer trials every second, third … sample is shown."""
_ANGLES = ("θ1", "θ2")
_TIME = Axis("time since the rods swing freely [s]")


def shown_samples(curves: Curves) -> slice:
    """Return which samples of each trial are shown."""
    return slice(None, None, max(1, -(-sum(len(trial.time) for trial in curves.trials) // MOST_SAMPLES)))


def angles(report: Section, curves: Curves) -> Iterator[Figure]:
    """Yield a figure for each trial: angles over windows, and what is left of them beneath on the same axis."""
    every = shown_samples(curves)
    for number, (trial, curve) in enumerate(zip(report["trials"], curves.trials, strict=True), start=1):
        errors = {model: curve.measured - getattr(curve, model.key) for model in models(report)}
        window = float(np.ptp(curve.time)) / max(int(curve.window.max()) + 1, 1)
        yield _figure(
            f"angles_{number}_{file_name(trial['name'])}",
            "motion",
            f"Angles of {trial['name']} ({_role(trial)})",
            f"Top: measured and simulated over windows of {window:.2g} s, whose initial states are fitted. Below: "
            "measured less simulated." + _thinned(every),
            report,
            curve,
            every,
            {model: getattr(curve, model.key) for model in models(report)},
            errors,
        )


def continuous_runs(report: Section, curves: Curves) -> Iterator[Figure]:
    """Yield the paper's contrast curves and angular errors of each trial, from one continuous run (Eq. 10)."""
    every = shown_samples(curves)
    for number, (trial, curve) in enumerate(zip(report["trials"], curves.trials, strict=True), start=1):
        runs = {model: getattr(curve, f"run_{model.key}") for model in models(report)}
        common = (
            "One simulation of the whole trial from its fitted initial state (Eq. 10). Where the motion is chaotic, no "
            "model follows it for long." + _thinned(every)
        )
        yield _figure(
            f"contrast_{number}_{file_name(trial['name'])}",
            "paper",
            f"Contrast curves of {trial['name']} ({_role(trial)})",
            f"{common} As the paper's Figs. 3, 4, 8 and 10.",
            report, curve, every, runs, {},
        )  # fmt: skip
        yield _figure(
            f"angular_error_{number}_{file_name(trial['name'])}",
            "paper",
            f"Angular error of {trial['name']} ({_role(trial)})",
            f"{common} As the paper's Figs. 11 and 12.",
            report, curve, every, {}, {model: curve.measured - run for model, run in runs.items()},
        )  # fmt: skip


def file_name(name: str) -> str:
    """Return a trial's name as a part of a file's name."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name)[:40]


def _figure(
    name: str,
    section: Place,
    title: str,
    caption: str,
    report: Section,
    curve: TrialCurves,
    every: slice,
    simulated: dict[Model, Array],
    errors: dict[Model, Array],
) -> Figure:
    time, spans = curve.time[every], _held_out(curve)
    panels = []
    for column, angle in enumerate(_ANGLES if simulated else ()):
        measured = Line("measured", "ink", time, curve.measured[every, column], width=2.5)
        lines = [
            Line(model.label, model.colour, time, angles[every, column], dashed=model.key == "before")
            for model, angles in simulated.items()
        ]
        panels.append(Panel(_TIME, Axis(f"{angle} [rad]"), [measured, *lines], height=190, held_out=spans))
    for column, angle in enumerate(_ANGLES if errors else ()):
        lines = [
            Line(model.label, model.colour, time, 1e3 * left[every, column], 1.2) for model, left in errors.items()
        ]
        panels.append(
            Panel(_TIME, Axis(f"error of {angle} [mrad]"), lines, height=150 if simulated else 190, held_out=spans)
        )
    return Figure(name, section, title, caption, _alternative(title, simulated, errors, curve), panels, shared_x=True)


def _alternative(title: str, simulated: dict[Model, Array], errors: dict[Model, Array], curve: TrialCurves) -> str:
    errors = errors or {model: curve.measured - angles for model, angles in simulated.items()}
    said = []
    for model, left in errors.items():
        known = left[np.isfinite(left).all(axis=1)]
        if not len(known):
            said.append(f"{model.label}: diverged")
            continue
        rms = 1e3 * np.sqrt(np.mean(known**2, axis=0))
        said.append(f"{model.label}: {rms[0]:.3g} mrad rms in θ1 and {rms[1]:.3g} mrad in θ2")
    return f"{title}, over {curve.time[-1]:.3g} s. Measured less simulated: {'; '.join(said)}."


def _held_out(curve: TrialCurves) -> list[tuple[float, float]]:
    """Return the windows that were held out, where others of the trial were not."""
    if curve.held_out[curve.window != NO_WINDOW].all():
        return []
    windows = np.unique(curve.window[curve.held_out])
    return [(float(t[0]), float(t[-1])) for t in (curve.time[curve.window == window] for window in windows)]


def _role(trial: Section) -> str:
    return "fitted" if trial["role"] == "fit" else "held out"


def _thinned(every: slice) -> str:
    return f" One of {every.step} samples is shown." if every.step > 1 else ""
