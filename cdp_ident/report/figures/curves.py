# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What `curves.npz` holds, drawn: angles over time, and missing torques with the fitted effects through them."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.parameters import INERTIA
from cdp_ident.report.curves import NO_WINDOW, Curves, TorqueCurves
from cdp_ident.report.figures.description import Axis, Colour, Figure, Line, Panel
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import Model, capitalised, effect_title, is_guessed, models, role_words

MOST_SAMPLES = 10_000
"""Of all trials together: a page with more has over 2 MB. Of longer trials every second, third … sample is shown."""
_TIME = Axis("time since the rods swing freely [s]")

_MOST_DOTS = 1500
_MOST_IN_TIME = 5000
"""Points of a line over time."""
_ONE_STD = "± one standard deviation"
_GAP = 1.5
"""Motion is interrupted where a step is longer than so many usual ones."""
_BINS = 25
_FEWEST_IN_BIN = 10
_SHOWN = 0.97
"""Share of the dots that lie inside the limits."""
_LABELS = {"speed": "speed of the {} joint [rad/s]", "angle": "angle of the {} joint [rad]"}


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
        # Windows that were held out are marked where others of the trial were not.
        held_out = np.unique(curve.window[curve.held_out])
        partly = not curve.held_out[curve.window != NO_WINDOW].all()
        times = [curve.time[curve.window == number] for number in (held_out if partly else ())]
        yield measured_and_simulated(
            f"{name}_{index}_{file_name(trial['name'])}",
            f"{title} of {trial['name']} ({role_words(trial)})",
            caption.format(window=window, thinned=thinned),
            curve.time[every],
            curve.measured[every],
            {model: getattr(curve, kind + model.key)[every] for model in models(report)},
            [(float(time[0]), float(time[-1])) for time in times],
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
    above, below = [], []
    for column, angle in enumerate(("θ1", "θ2")):
        lines, errors = [Line("measured", "ink", time, measured[:, column], width=2.5)], []
        for model, angles in simulated.items():
            left = 1e3 * (measured - angles)[:, column]
            lines.append(Line(model.label, model.key, time, angles[:, column], dash=model.dash))
            errors.append(Line(model.label, model.key, time, left, 1.2))
        above.append(Panel(_TIME, Axis(f"{angle} [rad]"), lines, height=190, held_out=held_out))
        below.append(Panel(_TIME, Axis(f"error of {angle} [mrad]"), errors, height=150, held_out=held_out))
    return Figure(name, title, caption, [*above, *below], shared_x=True)


class _Unit(NamedTuple):
    """What torques are shown in: over A22 where nothing but a guess gives N m."""

    name: str
    size: float
    """What a torque [N m] is multiplied by."""
    caption: str

    @classmethod
    def of(cls, report: Section) -> "_Unit":
        inertia = report["after"]["physical"][INERTIA.symbol]
        if is_guessed(inertia["value"], inertia["std"]):
            return cls("1/s²", 1 / inertia["value"], " Over A22, which is all that a free swing shows of torques.")
        return cls("mN m", 1e3, " In N m by A22, which a free swing does not show.")

    def axis(self, joint: str, limits: tuple[float, float] | None = None) -> Axis:
        """Return an axis of torques in a joint."""
        return Axis(f"{joint} joint [{self.name}]", limits=limits)


def missing_torques(report: Section, curves: Curves) -> Iterator[Figure]:
    """Yield what the models lack over speed, over time and over angle, in a panel for each joint."""
    shown = [(model, getattr(curves, model.key)) for model in models(report)]
    lacking = [k for k in range(len(JOINTS)) if any(np.any(torques.missing[:, k]) for _, torques in shown)]
    if not lacking:
        return  # effects were not looked for, or nothing is missing
    unit = _Unit.of(report)

    panels = {abscissa: list[Panel]() for abscissa in ("speed", "time", "angle")}
    for abscissa, column in product(_LABELS, lacking):
        marks = []
        for model, torques in shown:
            values = (unit.size * of[:, column] for of in (torques.missing, torques.std))
            marks += _cloud(model.label, f"mean {model.key}", model, torques.over(abscissa, column), *values)
        panels[abscissa].append(_panel(abscissa, JOINTS[column], marks, unit))
    panels["time"] = [
        Panel(
            _TIME,
            unit.axis(joint),
            [mark for model, torques in shown for mark in _over_time(model, torques, index, column, unit)],
            f"{trial['name']}, {joint} joint",
            190.0,
        )
        for index, trial in enumerate(report["trials"])
        for column, joint in enumerate(JOINTS)
        if any(np.any(torques.missing[torques.trial == index, column]) for _, torques in shown)
    ]
    for name, of in panels.items():
        bins = "" if name == "time" else " Lines are means in bins: what matters is a mean away from zero."
        yield Figure(
            f"torque_over_{name}",
            f"Missing torque over {name}",
            "Torque that no law of a model gives, as the motion shows it: what is most likely, given all readings, "
            "with a band of one standard deviation; in a joint that is not shown, none is missing beyond chance."
            f"{unit.caption}{bins}",
            of,
        )


def effects_through_residuals(report: Section, curves: Curves) -> Iterator[Figure]:
    """Yield for each effect that is a torque what is missing without it, and its fitted torque drawn through."""
    torques, unit = curves.after, _Unit.of(report)
    for place, (effect, of_effect) in enumerate(zip(report["effects"], torques.effects, strict=True), start=1):
        if not np.any(of_effect):
            continue  # an encoder's, or one of a trial that is not among these
        strongest = JOINTS[np.argmax(np.mean(of_effect**2, axis=0))]
        joint = strongest if effect["joint"] == "base" else effect["joint"]
        column = JOINTS.index(joint)
        shown = (of_effect, torques.missing + of_effect, torques.std)
        fitted, without, std = (unit.size * of[:, column] for of in shown)
        panels = []
        for abscissa in _LABELS:
            x = torques.over(abscissa, column)
            marks = _cloud("missing without it", "mean without it", models(report)[0], x, without, std)
            marks.append(_dots("the fitted effect", "ink", x, fitted, size=3.0, opacity=0.9))
            panels.append(_panel(abscissa, joint, marks, unit))
        yield Figure(
            f"effect_{place}_{effect['name']}_{effect['joint']}",
            f"{capitalised(effect_title(effect))}, through what is missing without it",
            f"What the final model would lack without this effect, and the effect's own torque: {effect['formula']}. "
            "It is a line where it depends on nothing but what is along the axis." + unit.caption,
            panels,
        )


def nonparametric_torques(report: Section) -> Iterator[Figure]:
    """Yield each nonparametric torque over what it depends on, with its band of uncertainty."""
    unit = _Unit.of(report)
    for index, effect in enumerate(report["effects"], start=1):
        if (curve := effect["curve"]) is None:
            continue
        x = np.array(curve["at"], dtype=float)
        torque, std = (unit.size * np.array(curve[key], dtype=float) for key in ("torque", "std"))
        marks = [Line("the torque", "after", x, torque, 2.5), *_band("95 % band", x, torque, CONFIDENCE * std)]
        axis = Axis(_LABELS[curve["over"]].format(effect["joint"]))
        likeness = f" It is like that of {curve['likeness']}." if curve["likeness"] else ""
        yield Figure(
            f"curve_{index}_{effect['name']}_{effect['joint']}",
            capitalised(effect_title(effect)),
            "A nonparametric torque, as the motion shows it, over the range that the motion covers."
            f"{likeness}{unit.caption}",
            [Panel(axis, unit.axis(effect["joint"]), marks, height=240)],
        )


def _dots(label: str, colour: Colour, x: Array, y: Array, size: float = 4.0, opacity: float = 0.3) -> Line:
    every = slice(None, None, max(1, -(-len(x) // _MOST_DOTS)))
    return Line(label, colour, x[every], y[every], 0.0, shape="circle", size=size, opacity=opacity)


def _cloud(label: str, of_mean: str, model: Model, x: Array, y: Array, std: Array) -> list[Line]:
    """Return a cloud, its mean in bins of equal counts at the bins' means, and that one's band.

    Neighbours share their errors, so that a mean is no surer than they are.
    """
    edges = np.unique(np.quantile(x, np.linspace(0, 1, _BINS + 1)))
    places = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, max(len(edges) - 2, 0))
    counts = np.bincount(places)
    enough = counts >= _FEWEST_IN_BIN
    at, mean, variance = (np.bincount(places, weights=values)[enough] / counts[enough] for values in (x, y, std**2))
    line = Line(of_mean, model.key, at, mean, 3.0, model.dash)
    return [_dots(label, model.key, x, y), line, *_band(f"{_ONE_STD}, {of_mean}", at, mean, np.sqrt(variance))]


def _over_time(model: Model, torques: TorqueCurves, trial: int, column: int, unit: _Unit) -> list[Line]:
    """Return the missing torque in a trial, and its band; both are interrupted where the motion is."""
    own = np.flatnonzero(torques.trial == trial)
    own = own[:: max(1, -(-len(own) // _MOST_IN_TIME))]
    time, (missing, std) = torques.time[own], (unit.size * of[own, column] for of in (torques.missing, torques.std))
    steps = np.diff(time)
    gaps = np.flatnonzero(steps > _GAP * np.median(steps)) + 1 if len(steps) else np.zeros(0, dtype=int)
    time, missing, std = (np.insert(values, gaps, np.nan) for values in (time, missing, std))
    line = Line(model.label, model.key, time, missing, 2.0, model.dash)
    return [line, *_band(f"{_ONE_STD}, {model.key}", time, missing, std)]


def _band(label: str, x: Array, y: Array, half_width: Array) -> list[Line]:
    """Return both edges of a band as one line that is interrupted between them, if it has any width."""
    edges = np.concatenate([y + half_width, [np.nan], y - half_width])
    return [Line(label, "quiet", np.concatenate([x, [np.nan], x]), edges, 1.0)] if np.any(half_width) else []


def _panel(abscissa: str, joint: str, marks: list[Line], unit: _Unit) -> Panel:
    """Return a panel whose limits leave out the few dots that are far off."""
    clouds = np.concatenate([mark.y for mark in marks if not mark.width])
    clouds = clouds[np.isfinite(clouds)]
    limit = max(1.2 * float(np.quantile(np.abs(clouds), _SHOWN)), 1e-9) if len(clouds) else 1.0
    return Panel(Axis(_LABELS[abscissa].format(joint)), unit.axis(joint, (-limit, limit)), marks, height=240)
