# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The effects that are searched for, and how files name them.

One added here is in the fit, the report, the simulation and ROS.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from cdp_ident.errors import OptionError
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.effects.encoders import ENCODERS
from cdp_ident.model.effects.forces import FORCES, MOTORS
from cdp_ident.model.effects.friction import FRICTION
from cdp_ident.user_input import number, quoted, refuse_unknown

NAMED: tuple[Effect, ...] = (*FRICTION, *FORCES, *ENCODERS)
CATALOGUE: tuple[Effect, ...] = (*NAMED, *CURVES)
WRITTEN: tuple[Effect, ...] = (*NAMED, MOTORS)
"""Whose laws are formulas: their code is made when the package is built."""
_own: dict[str, Effect] = {}

VARIANT = "variant"
"""The key that says which of several forms of an effect is meant."""
COEFFICIENTS = "coefficients"
"""The key of all parameters of a curve, in a list."""


def known_effects() -> tuple[Effect, ...]:
    """Return the catalogue's effects, and the user's own that this process has read (`effects.own`)."""
    return (*CATALOGUE, *_own.values())


def add_own(effects: Sequence[Effect]) -> None:
    """Make a user's own effects known, in the place of those of the same names."""
    names = {effect.name for effect in effects}
    for key in [key for key, effect in _own.items() if effect.name in names]:
        del _own[key]
    _own.update({effect.key: effect for effect in effects})


def forget_own() -> None:
    """Know the catalogue's effects alone."""
    _own.clear()


def effect_of(name: str, joint: str, given: Any, inertia: float, where: str) -> tuple[Effect, list[float]]:
    """Return an effect of the catalogue, and the values of all its parameters in the unit of the fit.

    Its parameters' physical values are given by name; what is optional may be left out. Of several forms of an effect
    the first is meant, unless `variant`, or the value of a parameter that is a part of its definition, says otherwise.
    The inertia about the cart's joint A22 is in kg m^2, and `where` is what the values stand in. Raises `OptionError`
    where a name is unknown, or a value is missing, no number or out of its range.
    """
    refuse_unknown([name], {effect.name for effect in known_effects()}, f"effect in {where}")
    forms = [effect for effect in known_effects() if effect.name == name]
    refuse_unknown([joint], {effect.joint for effect in forms}, f"joint in {where}: {name}")
    place = f"{where}: {name}: {joint}"
    if not isinstance(given, Mapping):
        raise OptionError(f"{place}: expected parameters with values, found {quoted(given)}")
    values = dict(given)
    effect = _form([effect for effect in forms if effect.joint == joint], values, place)
    if effect.curve:
        values = _named_one_by_one(effect, values, place)
    refuse_unknown(map(str, values), [p.name for p in effect.parameters], f"key in {place}")
    found = []
    for p in effect.parameters:
        if p.name in values:
            scale = p.scale(inertia)
            found.append(number(values[p.name], f"{place}: {p.name}", p.lower * scale, p.upper * scale) / scale)
        elif p.fixed or p.optional:
            found.append(p.typical)
        else:
            raise OptionError(f"{place}: {p.name} [{p.unit}] is missing")
    return effect, found


def _named_one_by_one(effect: Effect, values: dict[str, Any], where: str) -> dict[str, Any]:
    """Return a curve's parameters by name."""
    refuse_unknown(map(str, values), [COEFFICIENTS], f"key in {where}")
    given = values.get(COEFFICIENTS)
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != len(effect.parameters):
        raise OptionError(f"{where}: {COEFFICIENTS} must be a list of {len(effect.parameters)} numbers [N m]")
    return {p.name: value for p, value in zip(effect.parameters, given, strict=True)}


def _form(forms: list[Effect], values: dict[str, Any], where: str) -> Effect:
    """Return the form that is meant; the key that says so is taken out of the values."""
    if VARIANT in values:
        variant = values.pop(VARIANT)
        refuse_unknown([variant], [effect.variant for effect in forms], f"variant of {where}")
        forms = [effect for effect in forms if effect.variant == variant]
    for effect in forms:
        if all(values.get(p.name, p.lower) == p.lower for p in effect.parameters if p.fixed):
            return effect
    raise OptionError(f"{where}: {values} is not in the catalogue of effects")
