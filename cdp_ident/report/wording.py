# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers, names and findings of a report as people read them, and the few numbers that follow from it.

A number that is not finite is infinite.
"""

import math
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np

from cdp_ident.diagnosis.identification import GUESSED
from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.parameters import Group
from cdp_ident.report.figures.description import Dash
from cdp_ident.report.schema import Section

CERTAINTY = {"named": "", "probable": "probably ", "acts_like": "something that acts like "}
"""Words before the name of an effect, by how sure the name is."""
_OVER_INERTIA = {
    "N m": "1/s²",
    "N m s": "1/s",
    "N m s^2": "",
    "N m/s": "1/s³",
    "N m/rad": "1/s²",
    "N m/rad^3": "1/s²",
    "kg m^2": "",
}
"""Units, and the same over that of A22."""
_SAID_AS_POWER = 3.0
"""Decimal logarithm of odds from which on they are written as a power of ten."""


def capitalised(text: str) -> str:
    """Return a text that begins with a capital."""
    return text[:1].upper() + text[1:]


def with_std(value: float, std: float) -> str:
    """Write a value with its standard deviation, both to the latter's two leading digits."""
    if std == 0.0:
        return f"{value:.6g}"
    return f"{_to_digits_of(std, value)} ± {_to_digits_of(std, std)}"


def in_unit(value: float, std: float, symbol: str) -> str:
    """Write a value with its standard deviation and its unit."""
    return f"{with_std(value, std)} {unit(symbol)}".strip()


def is_guessed(value: float, std: float) -> bool:
    """Return whether a physical value rests on masses that nobody knows."""
    return std > GUESSED * abs(value)


def over_inertia(quantity: Mapping[str, Any]) -> str:
    """Write a torque over A22 where its physical value rests on masses that nobody knows; else nothing."""
    shown, std = (quantity["as_fitted"][of] for of in ("value", "std"))
    guessed = is_guessed(quantity["value"], quantity["std"])
    if quantity["unit"] not in _OVER_INERTIA or not guessed or std >= GUESSED * abs(shown):
        return ""
    return f"{in_unit(shown, std, _OVER_INERTIA[quantity['unit']])} over A22"


def quantity_words(quantity: Mapping[str, Any]) -> str:
    """Write a parameter of an effect: over A22 first where no mass is known."""
    words, first = in_unit(quantity["value"], quantity["std"], quantity["unit"]), over_inertia(quantity)
    return f"{first} ({words})" if first else words


def interval(value: float, std: float, lowest: float = -math.inf) -> str:
    """Write the 95 % interval of a value that is not below the `lowest`."""
    low, high = max(value - CONFIDENCE * std, lowest), value + CONFIDENCE * std
    return f"{_to_digits_of(std, low)} to {_to_digits_of(std, high)}"


def milliradians(radians: float) -> str:
    """Write an angle [rad] in mrad, without the unit."""
    return f"{1e3 * radians:.4g}"


def per_cent(share: float) -> str:
    """Write a fit [%], without the unit; a dash where it is not finite."""
    return f"{share:.4g}" if math.isfinite(share) else "–"


def chance(probability: float) -> str:
    """Write a probability; one that is nearly 0 or 1 is not said to be so."""
    if probability < 0.001:
        return "< 0.1 %"
    return "> 99.9 %" if probability > 0.999 else f"{100 * probability:.1f} %"


def odds(log10_odds: float) -> str:
    """Write the decimal logarithm of odds as odds; a dash where there are none."""
    if not math.isfinite(log10_odds):
        return "–"
    return f"{10.0**log10_odds:.2g} : 1" if abs(log10_odds) < _SAID_AS_POWER else f"10^{log10_odds:.0f} : 1"


def unit(symbol: str) -> str:
    """Write a unit; nothing for a number without one."""
    return "" if symbol == "1" else symbol


def _to_digits_of(deviation: float, value: float) -> str:
    """Write a number as precisely as two digits of its standard deviation allow."""
    if not (math.isfinite(value) and math.isfinite(deviation) and 1e-10 < deviation < 1e6):
        return f"{value:.5g}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(deviation)))}f}"


def summary(report: Section) -> str:
    """Return a fit in one sentence."""
    fitted = [trial["name"] for trial in report["trials"] if trial["role"] == "fit"]
    return f"{', '.join(fitted)}: {report['verdict']}"


class Model(NamedTuple):
    """One fitted model, as pictures name it."""

    key: Literal["before", "after"]
    """Its key in `report.json`, and the name of its curves and of its colour in every picture."""
    label: str

    @property
    def dash(self) -> Dash:
        """Of its lines, by which models differ beside their colours."""
        return "dash" if self.key == "before" else "solid"


def models(report: Section) -> list[Model]:
    """Return the paper's model and, where effects were found, the model with them."""
    before = Model("before", "before: the paper's model, fitted")
    return [before, Model("after", "after: with the effects found")] if report["effects"] else [before]


def effect_name(effect: Section) -> str:
    """Name an effect shortly, for lists and tables: its kind, its variant, and where."""
    parts = (effect["name"].replace("_", " "), effect["variant"], effect["joint"], effect.get("trial"))
    return ", ".join(filter(None, parts))


def effect_title(effect: Section) -> str:
    """Name an effect for people: what it is, and where."""
    of_encoders = {known.name for known in known_effects() if not known.moves and not known.of_both_encoders}
    part = "encoder" if effect["name"] in of_encoders else "joint"
    place = "base" if effect["joint"] == "base" else f"{effect['joint']} {part}"
    variant = f", {effect['variant']}" if effect["variant"] and not effect["curve"] else ""
    trial = f", in {effect['trial']}" if effect["trial"] else ""
    doubt = "" if effect["curve"] else CERTAINTY[effect["certainty"]]
    return f"{doubt}{effect['description']} ({place}{variant}{trial})"


def key_words(key: str) -> str:
    """Write an effect's key, as the selection has it, for people."""
    return key.replace("_", " ").replace(".", ", ")


def noise_floor(report: Section) -> float:
    """Return the noise of both encoders' angles together [rad]."""
    return float(np.sqrt(np.mean(np.square(list(report["noise_rad"].values())))))


def group_words(group: Group) -> str:
    """Write a base parameter's short name and what it stands for."""
    return f"{short_name(group.symbol)} = {group.formula}"


def role_words(trial: Section) -> str:
    """Say what a trial was for."""
    return "fitted" if trial["role"] == "fit" else "held out"


def weights_words(trial: Section) -> str:
    """Say which weights a trial has: mass, place and rod of each; nothing where it has none."""
    return "; ".join(
        f"{with_std(weight['mass'], weight['mass_std'])} kg at {with_std(weight['place'], weight['place_std'])} m "
        f"on the {weight['rod']} rod"
        for weight in trial["weights"]
    )


def short_name(symbol: str) -> str:
    """Write a base parameter as a fraction, and a parameter of an effect or weight in words."""
    if symbol.startswith("weight_error."):
        return symbol.replace("_", " ").replace(".", ", ", 2)
    return key_words(symbol) if "." in symbol else symbol.replace("one_over_", "1/").replace("_over_", "/")
