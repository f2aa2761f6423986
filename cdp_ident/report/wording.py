"""What several forms of a report say in the same words, and the few numbers that they derive from it."""

import numpy as np

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import SensorEffect
from cdp_ident.model.parameters import CONSTANTS, GROUPS, SYMBOLS, Group, groups_of
from cdp_ident.report.contents import Section
from cdp_ident.report.formatting import CERTAINTY

_OF_ENCODERS = frozenset(effect.name for effect in CATALOGUE if isinstance(effect, SensorEffect))
STAGES = {"nominal": "nominal values", "search": "after the search", "refined": "refined"}


def nominal_value(report: Section, symbol: str) -> float:
    """Return what was known of a physical parameter before: its measured value, or else its nominal one."""
    options = report["run"]["options"]
    if symbol in (constant.symbol for constant in CONSTANTS):
        return float(options[symbol])
    known = options.get(f"known.{symbol}")
    return float(options[f"nominal.{symbol}"] if known is None else known)


def nominal_groups(report: Section) -> dict[str, float]:
    """Return the groups of the values known before, by their symbols."""
    physical = np.array([nominal_value(report, symbol) for symbol in SYMBOLS])
    values = groups_of(physical, nominal_value(report, "L"))
    return {group.symbol: float(value) for group, value in zip(GROUPS, values, strict=True)}


def how_determined(report: Section, symbol: str) -> str:
    """Say how the model that a report ends with came to the value of a physical parameter."""
    quantity = report["after"]["physical"][symbol]
    if quantity["std"] == 0.0:
        return "given"
    if report["run"]["options"].get(f"known.{symbol}") is not None:
        return "measured"
    return "yes" if quantity["determined"] else "no: nearest to nominal"


def effect_title(effect: Section) -> str:
    """Name an effect for people: what it is, and where."""
    part = "encoder" if effect["name"] in _OF_ENCODERS else "joint"
    place = "base" if effect["joint"] == "base" else f"{effect['joint']} {part}"
    variant = f", {effect['variant']}" if effect["variant"] and not effect["curve"] else ""
    trial = f", in {effect['trial']}" if effect["trial"] else ""
    doubt = "" if effect["curve"] else CERTAINTY[effect["certainty"]]
    return f"{doubt}{effect['description']} ({place}{variant}{trial})"


def key_words(key: str) -> str:
    """Write an effect's key, as the selection has it, for people."""
    name, _, rest = key.partition(".")
    return f"{name.replace('_', ' ')}, {rest.replace('.', ', ')}"


def action_words(step: Section) -> str:
    """Say what was done at a step of the selection."""
    said = str(step["action"])
    for key in sorted((effect.key for effect in CATALOGUE), key=len, reverse=True):
        said = said.replace(key, key_words(key))
    return said


def noise_floor(report: Section) -> float:
    """Return the noise of both encoders' angles together [rad]."""
    return float(np.sqrt(np.mean(np.square(list(report["noise_rad"].values())))))


def group_words(group: Group) -> str:
    """Write a group's short name and what it stands for."""
    return f"{short_name(group.symbol)} = {group.formula}"


def short_name(symbol: str) -> str:
    """Write a group's symbol as the fraction that it stands for, and a parameter of an effect in words."""
    return key_words(symbol) if "." in symbol else symbol.replace("_over_", "/")
