"""The torques that the models lack, over speed and angle of the joints, and the fitted effects drawn through them."""

from collections.abc import Iterator
from typing import Literal

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.identifiability import CONFIDENCE
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.report.curves import Curves, TorqueCurves
from cdp_ident.report.figures.description import Axis, Dots, Figure, Line, Panel
from cdp_ident.report.figures.models import models
from cdp_ident.report.figures.palette import Colour
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import effect_title

Array = npt.NDArray[np.float64]
Abscissa = Literal["speed", "angle"]

_MOST_DOTS = 1500
_BINS = 25
_FEWEST_IN_BIN = 10
_SHOWN = 0.97
"""Share of the dots that lie inside the limits."""
_LABELS: dict[Abscissa, str] = {"speed": "speed of the {} joint [rad/s]", "angle": "angle of the {} joint [rad]"}


def missing_torques(report: Section, curves: Curves) -> Iterator[Figure]:
    """Yield what the models lack over speed and over angle, in a panel for each joint."""
    torques = curves.torques
    for abscissa in _LABELS:
        panels = []
        for column, joint in enumerate(JOINTS):
            x = _abscissa(torques, abscissa, column)
            marks: list[Dots | Line] = []
            for model in models(report):
                missing = 1e3 * getattr(torques, model.key)[:, column]
                marks.append(_cloud(model.label, model.colour, x, missing))
                marks.append(_mean(f"mean {model.key}", model.colour, x, missing, dashed=model.key == "before"))
            panels.append(_panel(abscissa, joint, marks))
        yield Figure(
            f"torque_over_{abscissa}",
            "torques",
            f"Missing torque over {abscissa}",
            "Torque that the measured motion, fitted and held out, shows and the model does not have, with its mean in "
            "bins. Accelerations are those of local cubics over 0.1 s, so single dots are noisy: what matters is a "
            "mean away from zero."
            + _in_newton_metres(),
            f"Missing torque over {abscissa}, root mean square in mN m: " + "; ".join(
                f"{joint} joint " + ", ".join(
                    f"{_rms(1e3 * getattr(torques, model.key)[:, column]):.3g} {model.key}" for model in models(report)
                )
                for column, joint in enumerate(JOINTS)
            ) + ".",
            panels,
        )  # fmt: skip


def effects_through_residuals(report: Section, curves: Curves) -> Iterator[Figure]:
    """Yield for each effect that is a torque what is missing without it, and its fitted torque drawn through."""
    torques = curves.torques
    for number, (effect, of_effect) in enumerate(zip(report["effects"], torques.effects, strict=True), start=1):
        if not np.any(of_effect):
            continue  # an encoder's, or one of a trial that is not among these
        column = (
            int(np.argmax(np.mean(of_effect**2, axis=0)))
            if effect["joint"] == "base"
            else JOINTS.index(effect["joint"])
        )
        fitted, without = 1e3 * of_effect[:, column], 1e3 * (torques.after + of_effect)[:, column]
        panels = []
        for abscissa in _LABELS:
            x = _abscissa(torques, abscissa, column)
            marks: list[Dots | Line] = [
                _cloud("missing without it", "before", x, without),
                _mean("mean without it", "before", x, without, dashed=True),
                _cloud("the fitted effect", "ink", x, fitted, size=3.0, opacity=0.9),
            ]
            panels.append(_panel(abscissa, JOINTS[column], marks))
        title = effect_title(effect)
        yield Figure(
            f"effect_{number}_{effect['name']}_{effect['joint']}",
            "torques",
            f"{title[0].upper()}{title[1:]}, through what is missing without it",
            f"What the final model would lack without this effect, and the effect's own torque: {effect['formula']}. "
            "It is a line where it depends on nothing but what is along the axis." + _in_newton_metres(),
            f"{title}: a torque between {fitted.min():.3g} and {fitted.max():.3g} mN m. In the joint "
            f"{_rms(without):.3g} mN m rms are missing without it, {_rms(1e3 * torques.after[:, column]):.3g} with it.",
            panels,
        )


def torques_without_a_name(report: Section) -> Iterator[Figure]:
    """Yield each torque that has no name, over what it depends on, with its band of uncertainty."""
    for number, effect in enumerate(report["effects"], start=1):
        if (curve := effect["curve"]) is None:
            continue
        x, torque, std = (np.array(curve[key], dtype=float) for key in ("at", "torque", "std"))
        marks = [
            Line("the torque", "after", x, 1e3 * torque, width=2.5),
            Line("95 % band", "quiet", x, 1e3 * (torque + CONFIDENCE * std), dashed=True),
            Line("95 % band, below", "quiet", x, 1e3 * (torque - CONFIDENCE * std), dashed=True),
        ]
        title, likeness = effect_title(effect), f" It is like that of {curve['likeness']}." if curve["likeness"] else ""
        label = _LABELS[curve["over"]].format(effect["joint"])
        place = int(np.argmax(np.abs(torque)))
        yield Figure(
            f"curve_{number}_{effect['name']}_{effect['joint']}",
            "torques",
            f"{title[0].upper()}{title[1:]}",
            "A torque that nobody has a name for, as the motion shows it, over the range that the motion covers."
            + likeness
            + _in_newton_metres(),
            f"{title}: up to {1e3 * torque[place]:.3g} ± {1e3 * std[place]:.2g} mN m at {x[place]:.3g}." + likeness,
            [Panel(Axis(label), Axis(f"{effect['joint']} joint [mN m]"), marks, height=240)],
        )


def _in_newton_metres() -> str:
    return " In N m for the masses nearest to the nominal ones: a free swing shows torques over A22 only."


def _rms(torque: Array) -> float:
    return float(np.sqrt(np.mean(torque**2)))


def _abscissa(torques: TorqueCurves, abscissa: Abscissa, column: int) -> Array:
    values = getattr(torques, abscissa)[:, column]
    return values if abscissa == "speed" else (values + np.pi) % (2 * np.pi) - np.pi


def _cloud(label: str, colour: Colour, x: Array, y: Array, size: float = 4.0, opacity: float = 0.3) -> Dots:
    every = slice(None, None, max(1, -(-len(x) // _MOST_DOTS)))
    return Dots(label, colour, x[every], y[every], size, opacity)


def _mean(label: str, colour: Colour, x: Array, y: Array, dashed: bool) -> Line:
    """Return the mean in bins of equal counts, at the bins' means."""
    edges = np.unique(np.quantile(x, np.linspace(0, 1, _BINS + 1)))
    places = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, max(len(edges) - 2, 0))
    counts = np.bincount(places)
    enough = counts >= _FEWEST_IN_BIN
    at, mean = (np.bincount(places, weights=values)[enough] / counts[enough] for values in (x, y))
    return Line(label, colour, at, mean, width=3.0, dashed=dashed)


def _panel(abscissa: Abscissa, joint: str, marks: list[Dots | Line]) -> Panel:
    """Return a panel whose limits leave out the few dots that are far off."""
    clouds = np.concatenate([mark.y for mark in marks if isinstance(mark, Dots)])
    limit = max(1.2 * float(np.quantile(np.abs(clouds), _SHOWN)), 1e-9)
    return Panel(
        Axis(_LABELS[abscissa].format(joint)), Axis(f"{joint} joint [mN m]", limits=(-limit, limit)), marks, height=240
    )
