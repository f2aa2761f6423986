# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The text of the gallery of effects."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.formulas.typesetting import Formula


@dataclass(frozen=True)
class Entry:
    """One effect of the gallery."""

    kind: str
    hidden: str
    """Strength at which it was looked for at first, with how visible it is over the noise."""
    found: tuple[str, ...]
    """Keys of what was found there, with how sure each name is."""
    before: float
    """Error on the held-out trial with the paper's model [mrad]."""
    after: float
    """The same with what was found [mrad]."""
    noise: float
    """Of the encoders [mrad]."""
    alternatives: tuple[tuple[str, float], ...]
    """What else was fitted at the first step, and log10 of the chosen model's odds over it."""
    also_possible: tuple[str, ...]
    found_at: tuple[str, ...]
    """Strengths at which it was found."""
    lost_at: tuple[str, ...]
    """Strengths at which it was not, or why there is no result."""


@dataclass(frozen=True)
class Strengths:
    """How visible effects are, over the noise."""

    drawn: float
    """In pictures."""
    strong: float
    """When they are looked for at first."""
    weaker: float
    """At the second time."""
    weakest: float
    """At the last."""


_NAMES = {
    "rotor_inertia": "geared_rotor",
    "partial_rub": "unknown_torque",
    "heavy_cart": "pivot_compliance",
    "drifting_encoder_offset": "encoder_offset",
    "bob_drag": "air_drag",
    "eddy_brake": "varying_viscosity",
}
"""What the catalogue calls that which has another name in the reference."""
_HIDDEN_AS = {
    "partial_rub": "hidden as a bearing that rubs over a part of its turn; dry friction over the angle",
    "heavy_cart": "hidden as a heavy cart on a soft stand",
    "drifting_encoder_offset": "by the end of a trial",
    "bob_drag": "hidden as a body on the rod",
    "eddy_brake": "hidden in a part of the turn",
    "backlash": "half of the gap, as in the table above",
    "rotor_inertia": "hidden as a rotor that turns with the outer joint",
}
_DISTINCTION = {
    "coulomb_friction": (
        "A step at zero speed: the same torque at any speed, against the motion. Viscous friction is a slope;"
        " Stribeck friction has peaks beside the step."
    ),
    "stribeck_friction": (
        "A step at zero speed with a peak on each side. Without enough slow motion it cannot be distinguished from "
        "Coulomb friction, which is then taken as the simpler one."
    ),
    "presliding_friction": (
        "A step at zero speed that comes late: after each turn the torque needs an angle of some `give` to change its "
        "sign. Where that angle is small against what the noise shows, Coulomb friction is found."
    ),
    "drifting_friction": (
        "A step at zero speed whose height changes along each trial. Coulomb friction has the same step all the time, "
        "and is found where the change is too small to be seen."
    ),
    "load_friction": (
        "A step at zero speed whose height follows the bearing's load: higher where the rods swing through "
        "fast. Coulomb friction has the same step at any load."
    ),
    "quadratic_friction": (
        "A parabola over the joint's speed, with the sign of the speed. In the inner joint it is the same "
        "motion as air drag on the inner rod; in the outer joint, drag goes with the rod's absolute speed "
        "instead."
    ),
    "air_drag": (
        "A parabola over the rod's absolute speed. Over the joint's speed it is blurred, which distinguishes it from "
        "quadratic friction."
    ),
    "joint_spring": (
        "A straight line over the joint's angle. Gravity is a sine of the absolute angles, so large swings "
        "distinguish them."
    ),
    "constant_torque": (
        "The same torque always. Beside dry friction it makes the steps in both directions unequal; a spring's torque "
        "changes with the angle, and gravity's that is askew with the rods' absolute angles."
    ),
    "magnet": (
        "A torque over the joint's angle that draws to one place, or away from it, and is felt near it alone. A "
        "cogging torque repeats over the turn."
    ),
    "end_stop": (
        "No torque up to an angle, and from there on one that pushes back, less on the way out than on the way in. A "
        "spring's torque begins where it is at ease."
    ),
    "varying_viscosity": (
        "Viscous friction whose slope over the speed changes over the joint's turn. Dry friction that changes over the "
        "turn is a step at zero speed."
    ),
    "drifting_viscosity": (
        "Viscous friction whose slope over the speed changes along each trial. Drag and quadratic friction, which make "
        "the slope fall as the swings grow smaller, do so with the speed and not with the time."
    ),
    "cogging_torque": ("A wave over the joint's angle, some periods a turn."),
    "impulse": (
        "One window fits far worse than all others, from one instant on. An impulse makes a speed jump, lost "
        "counts an angle."
    ),
    "encoder_offset": (
        "The angle is off by a constant, so gravity seems to be inclined. Of the inner encoder it is the same "
        "motion as a base that is not level. One whose zero drifts is off by more and more."
    ),
    "encoder_scale": ("The error grows with the angle from hanging; an offset is constant, an eccentricity periodic."),
    "encoder_eccentricity": ("The error is a sine of the joint's angle, once a turn."),
    "encoder_harmonic": ("The error is a sine of two to four times the joint's angle."),
    "encoder_interpolation": (
        "The error is a sine of many times the joint's angle, so it looks like noise over time. Rounding repeats more "
        "often still, and noise has no period."
    ),
    "encoder_compliance": (
        "The error is minus the joint's acceleration times the compliance: the encoder lags behind where the joint "
        "speeds up. A belt that oscillates leaves ripples at its own frequency, seen by this encoder alone."
    ),
    "encoder_filter": (
        "Beyond a delay, the error is half of the joint's acceleration times the square of the time constant, to the "
        "other side than with an elastic coupling. Where the noise hides that, a late encoder is found."
    ),
    "oblique_view": (
        "Both absolute angles are off by the same sine of twice the angle. An encoder's harmonic is in one joint alone."
    ),
    "backlash": (
        "The angle's error is half of the gap, against the motion, and changes its sign after each turn while the "
        "joint goes through the gap. That of a late encoder is proportional to the speed."
    ),
    "encoder_slip": ("One angle jumps at an instant and stays off; the speeds do not jump."),
    "gravity_tilt": (
        "Gravity has a constant share sideways. An inner encoder that is off by the tilt gives the same "
        "motion: the two cannot be told apart, and the report names both."
    ),
    "side_force": (
        "A force from the side that does not go with the rods' masses: the torques on both rods are cosines of their "
        "angles, as with a base that is not level, in another ratio. Drag goes with the speed."
    ),
    "pivot_compliance": (
        "What is missing follows the rods' horizontal pull. A stand that oscillates by itself leaves ripples "
        "at its own frequency."
    ),
    "time_offset": ("The outer angle's error is proportional to its speed: the delay times the speed."),
    "rod_flex": (
        "Both encoders' errors follow the force across the rod's end, one of them half of the other. An error of one "
        "encoder follows its angle alone."
    ),
    "geared_rotor": (
        "The rods' accelerations are coupled by a constant, instead of by the cosine of the angle between the rods."
    ),
    "unknown_torque": (
        "A torque over a joint's angle or speed whose shape no named effect has. It is fitted as a smooth curve."
    ),
}
"""How each effect differs from similar ones."""
_HEAD = """\
# Gallery of effects

What each effect of the catalogue leaves when the model lacks it, how it differs from similar ones, and how weak it
may be. The page is made by `python -m benchmarks.gallery`; its numbers are those of the selection before effects were
chosen by evidence, but for encoders that are off, a base that is not level, a force from the side, presliding friction
and viscosity that drifts.

**The rig** is the paper's (the last row of Table 5, L = 0.4 m), sampled at 200 Hz by encoders of 8000 counts a turn
with 0.3 mrad of noise, which makes {noise:.2g} mrad in the absolute angles. Two swings of 12 s are fitted, a third is
held out. One effect is hidden at a time, by `reference/`, which shares no code with the package.

**Pictures** show what the paper's model leaves, fitted to the swings of a rig whose effect is {of.drawn:g} times as
visible as the noise. *Visible* is the root mean square by which it moves the angles beyond what other parameters and
other initial states could imitate over 2.5 s. Left: measured less simulated angles over the windows of one swing,
theta1 pale, theta2 strong; the grey band is the noise. Middle and right: the missing torque of the joint, averaged in
bins over speed and over angle (not for errors of encoders and effects of an instant, which are not lasting torques).

**Strengths**: each effect is hidden at {of.strong:g} times the noise and looked for. It is hidden again at
{of.weaker:g}, and then at half as much each time, down to {of.weakest:g}, until it is not found any more; where
{of.weaker:g} is too weak already, at 1.6 and 3.2. The weakest strength is thus known within a factor of two, for this
rig and one draw of the noise; where nothing stands under *not found at*, nothing weaker was tried. *Found* means that
the effect's name, or one that is the same motion, is in the result as *named* or *probable* (of a torque without a
name: that it is in the result).

"""


def read_entries(path: Path) -> list[Entry]:
    """Read what was found before."""
    found: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
    return [Entry(**{name: _tuples(value) for name, value in entry.items()}) for entry in found]


def page(entries: Sequence[Entry], strengths: Strengths) -> str:
    """Return the page."""
    noise = max(entry.noise for entry in entries)
    text = _HEAD.format(noise=noise, of=strengths) + _table(entries)
    names = dict.fromkeys(effect.name for effect in CATALOGUE)
    for name in names:
        forms = [effect for effect in CATALOGUE if effect.name == name]
        text += f"\n## {_title(name)}\n\n{_DISTINCTION[name]}\n\n{_description(forms)}"
        for entry in entries:
            if _name(entry) == name:
                text += _section(entry)
    return text


def _table(entries: Sequence[Entry]) -> str:
    lines = ["| effect | joint | weakest strength found (over the noise) | not found at |", "|---|---|---|---|"]
    for entry in entries:
        part, joint = entry.kind.split(".")
        name = _title(_name(entry))
        note = f" ({part.replace('_', ' ')})" if part != _name(entry) else ""
        found = _weakest(entry) or "none of those tried"
        lines.append(f"| {name}{note} | {joint} | {found} | {_strongest_lost(entry)} |")
    return "\n".join(lines) + "\n"


def _section(entry: Entry) -> str:
    part, joint = entry.kind.split(".")
    place = "base" if joint == "base" else f"{joint} joint"
    text = f"\n### {_title(part)}, {place}\n\n![{_title(part)}, {place}: residuals](effects/{entry.kind}.svg)\n\n"
    hidden_as = f", {_HIDDEN_AS[part]}" if part in _HIDDEN_AS else ""
    found = ", ".join(f"`{key}`" for key in entry.found) or "nothing"
    text += (
        f"Hidden: {entry.hidden}{hidden_as}. Found: {found}. Held-out error {entry.before:.2f} mrad without, "
        f"{entry.after:.2f} mrad with it; noise {entry.noise:.2f} mrad.\n"
    )
    if entry.also_possible:
        text += f"The data do not distinguish it from: {', '.join(entry.also_possible)}.\n"
    if entry.alternatives:
        others = ", ".join(f"`{key}` {odds:.0f}" for key, odds in entry.alternatives)
        text += f"Other candidates, fitted in its place (log10 of the odds of the chosen model over them): {others}.\n"
    return text


def _description(forms: Sequence[Effect]) -> str:
    if forms[0].name == "unknown_torque":
        return "Sources: penalised splines, Eilers and Marx, 1996.\n"
    rows = dict.fromkeys(
        (
            _variant(effect),
            Formula(effect.formula).latex,
            ", ".join(f"{p.name} [{p.unit}]" for p in effect.parameters if not p.fixed),
            effect.source,
        )
        for effect in forms
    )
    lines = ["| form | formula | parameters | source |", "|---|---|---|---|"]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def _variant(effect: Effect) -> str:
    if not effect.harmonic:
        return effect.variant
    variants = [one.variant for one in CATALOGUE if (one.name, one.joint) == (effect.name, effect.joint)]
    return f"{variants[0].split()[0]} to {variants[-1]}"


def _name(entry: Entry) -> str:
    part = entry.kind.split(".")[0]
    return _NAMES.get(part, part)


def _title(name: str) -> str:
    return name.replace("_", " ").capitalize()


def _visible(strength: str) -> float:
    return float(strength.rpartition("(")[2].rstrip(")"))


def _weakest(entry: Entry) -> str:
    return min(entry.found_at, key=_visible, default="")


def _strongest_lost(entry: Entry) -> str:
    return max((lost for lost in entry.lost_at if lost.endswith(")")), key=_visible, default="")


def _tuples(value: Any) -> Any:
    return tuple(_tuples(inner) for inner in value) if isinstance(value, list) else value
