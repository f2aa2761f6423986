# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A user's own effects: laws that the catalogue lacks, as a file describes them.

    eddy_current_brake:
      joint: inner
      torque: -2*torque*speed/critical_speed/(1 + (speed/critical_speed)^2)
      parameters:
        torque: {unit: N m, limits: [0, 1], typical: 0.01}
        critical_speed: {unit: rad/s, limits: [0.1, 100], typical: 3}

Formulas are in the words of `formulas.language`. In the model torques are over A22. That a formula says the same of
these as of physical values is checked by the mass in the units of its parameters: a torque has it once, an angle does
not.
"""

import ast
import ctypes
import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cdp_ident.errors import OptionError
from cdp_ident.model.effects import catalogue
from cdp_ident.model.effects.effect import JOINTS, UNITS, Effect, EffectParameter, Law, State, mass_in
from cdp_ident.model.formulas import language as words
from cdp_ident.model.formulas.algebra import Tree
from cdp_ident.model.formulas.compiled import compiled_law
from cdp_ident.model.formulas.syntax import error_at, names_used, parse
from cdp_ident.user_input import mapping_of, number, quoted, refuse_unknown
from cdp_ident.yaml_file import read_yaml

OWN_EFFECTS = "own_effects"
"""The key of their definitions in files."""

_ADDS = {"torque": 1, "torques": 1, "friction": 1, "cart": 0, "reading": 0, "readings": 0, "lateness": 0}
"""What a law may add to, and how often the unit of that has a mass."""
_OF_TWO = ("torques", "readings")
_KEYS = ("joint", "description", "parameters", "where", "states", *_ADDS)
_PARAMETER_KEYS = ("unit", "limits", "typical", "prior_width", "shape", "begins", "resolves")
_STATE_KEYS = ("rate", "limit", "start_std")
_PLACES = (*JOINTS, "base")
_NAME = re.compile(r"[a-z][a-z0-9_]{0,40}")
_MOST_RATES = 3
"""Rates of change in a law, at most."""
_MOST = 20
"""Effects in a file, and parameters of each, at most."""


def read_own_effects(path: Path) -> dict[str, Any]:
    """Return the definitions in a YAML file. Raises `OptionError` where it cannot be read, or is no mapping."""
    try:
        content: Any = read_yaml(path)
    except (OSError, ValueError) as error:
        raise OptionError(f"the effects' file {path} cannot be read: {error}") from error
    if not isinstance(content, dict) or not content:
        raise OptionError(f"{path}: expected names of effects with their laws, found {quoted(content)}")
    return content


def as_text(definitions: Mapping[str, Any]) -> str:
    """Return definitions in one line."""
    return json.dumps(definitions, sort_keys=True)


def of_text(text: Any, where: str) -> dict[str, Any]:
    """Return the definitions of a line. Raises `OptionError` where it has none."""
    try:
        definitions = json.loads(text)
    except (TypeError, ValueError, RecursionError) as error:
        raise OptionError(f"{where}: {OWN_EFFECTS} has no definitions of effects: {error}") from None
    if not isinstance(definitions, dict):
        raise OptionError(f"{where}: {OWN_EFFECTS} has no definitions of effects")
    return definitions


def use(definitions: Mapping[str, Any], inertia: float, where: str) -> None:
    """Make effects known beside the catalogue's, in the place of those of the same names; see `effects_of`."""
    effects = effects_of(definitions, inertia, where)
    for effect in effects:
        added = _added_at_zero(effect)  # what only deriving it shows is found out now
        if added != 0.0:
            zero = " and ".join(p.name for p in effect.parameters if not p.shape)
            raise OptionError(
                f"{where}: {effect.name}: where {zero} is 0 it adds {added:g}, not nothing; a parameter that means "
                "nothing without another one has `shape: true`"
            )
    catalogue.add_own(effects)


def _added_at_zero(effect: Effect) -> float:
    """Return the most that an effect's compiled law adds somewhere where all its strengths are zero."""
    inputs = np.linspace(0.3, 1.7, len(words.INPUTS))
    parameters = np.array([p.typical if p.shape else 0.0 for p in effect.parameters])
    sums, rows = (
        np.zeros((len(words.SUMS), words.PARAMETERS)),
        np.zeros((words.ROWS, words.PARAMETERS + len(parameters))),
    )
    law = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(compiled_law(effect))
    law(*(array.ctypes.data for array in (inputs, parameters, sums, rows)))
    rows[words.RATES : words.RATES + effect.states] = 0.0
    return float(np.abs([*sums[:, words.VALUE], *rows[:, words.VALUE]]).max())


def effects_of(definitions: Mapping[str, Any], inertia: float, where: str) -> tuple[Effect, ...]:
    """Return the effects of definitions by name, of one joint or several.

    The inertia about the cart's joint A22 is in kg m^2, and `where` is what they stand in. Raises `OptionError` where a
    definition is wrong; the message says where.
    """
    if len(definitions) > _MOST:
        raise OptionError(f"{where}: {len(definitions)} effects; at most {_MOST} are read")
    taken = {effect.name for effect in catalogue.CATALOGUE}
    effects: list[Effect] = []
    for name, definition in definitions.items():
        place = f"{where}: {_name(name, f'name of an effect in {where}')}"
        if name in taken:
            raise OptionError(f"{place}: the catalogue has an effect of this name; choose another one")
        content = mapping_of(definition, place, _KEYS)
        if "joint" not in content:
            raise OptionError(f"{place}: joint is missing: {', '.join(_PLACES)}, or a list of them")
        joints = content["joint"] if isinstance(content["joint"], list) else [content["joint"]]
        refuse_unknown(joints, _PLACES, f"joint of {place}")
        if not joints or len(set(joints)) < len(joints):
            raise OptionError(f"{place}: joint is {quoted(joints)}; expected each joint once")
        effects += [_effect(name, joint, content, inertia, place) for joint in joints]
    return tuple(effects)


def _effect(name: str, joint: Any, content: Mapping[str, Any], inertia: float, place: str) -> Effect:
    parameters = _parameters(content.get("parameters"), inertia, place)
    units = {p.name: p.inertia_power for p in parameters}
    states = mapping_of(content.get("states", {}), f"{place}: states")
    defined = mapping_of(content.get("where", {}), f"{place}: where")
    if len(defined) > _MOST:
        raise OptionError(f"{place}: where: {len(defined)} parts; at most {_MOST} are read")
    if len(states) > words.MOST_STATES:
        raise OptionError(f"{place}: {len(states)} states; a law has at most {words.MOST_STATES}")
    masses = {**{word: words.MASSES.get(word, 0) for word in words.words_of(joint)}, "pi": 0}
    for own in (*units, *states, *defined):
        _name(own, f"name in {place}")
        if own in masses:
            raise OptionError(f"{place}: {own} has a meaning already; give it another name")
        masses[own] = units.get(own, 0)
    for k, (part, text) in enumerate(defined.items()):  # each may use those before it
        known = {word: mass for word, mass in masses.items() if word not in list(defined)[k:]}
        masses[part] = _checked(text, known, f"{place}: where: {part}")
    formulas = {key: _formulas(key, content[key], masses, f"{place}: {key}") for key in _ADDS if key in content}
    if not formulas:
        raise OptionError(f"{place}: what does it add to? expected one of {', '.join(_ADDS)}")
    law = Law(
        where=tuple(defined.items()),
        states=tuple(_state(own, given, masses, f"{place}: states: {own}") for own, given in states.items()),
        **formulas,
    )
    if sum(len(re.findall(r"\brate\b", text)) for text in law.texts) > _MOST_RATES:
        raise OptionError(f"{place}: more than {_MOST_RATES} rates; each makes the law several times as long")
    if unused := sorted(units.keys() - names_used(law.texts)):
        raise OptionError(f"{place}: the parameter {unused[0]} is in no formula")
    description = content.get("description", name.replace("_", " "))
    if not isinstance(description, str) or not 0 < len(description) <= 100:
        raise OptionError(f"{place}: description is {quoted(description)}; expected a few words")
    return Effect(name, joint, description, law, parameters, "the user's own law")


def _formulas(key: str, given: Any, masses: Mapping[str, int], where: str) -> Any:
    """Return the formula of what a law adds, or both of what it adds to both rods or encoders."""
    if key not in _OF_TWO:
        _checked(given, masses, where, _ADDS[key])
        return given
    if not isinstance(given, list) or len(given) != 2:
        raise OptionError(f"{where}: expected a list of two formulas, found {quoted(given)}")
    for text in given:
        _checked(text, masses, where, None if text in ("0", "0.0") else _ADDS[key])
    return tuple(given)


def _state(name: str, given: Any, masses: Mapping[str, int], where: str) -> State:
    content = mapping_of(given, where, _STATE_KEYS)
    _checked(content.get("rate", ""), masses, f"{where}: rate", 0)
    limit = number(content.get("limit", math.inf), f"{where}: limit", 0.0) if "limit" in content else math.inf
    return State(name, content["rate"], limit, number(content.get("start_std", 1.0), f"{where}: start_std", 0.0))


def _parameters(given: Any, inertia: float, place: str) -> tuple[EffectParameter, ...]:
    content = mapping_of(given, f"{place}: parameters")
    if not 0 < len(content) <= _MOST:
        raise OptionError(f"{place}: {len(content)} parameters; expected at least one, and at most {_MOST}")
    parameters = tuple(_parameter(name, one, inertia, f"{place}: {name}") for name, one in content.items())
    strengths = [p for p in parameters if not p.shape]
    if not any(p.lower <= 0.0 <= p.upper for p in strengths):
        raise OptionError(f"{place}: no parameter can be 0, so that the effect cannot be absent; put 0 in its limits")
    return parameters


def _parameter(name: Any, given: Any, inertia: float, where: str) -> EffectParameter:
    content = mapping_of(given, where, _PARAMETER_KEYS)
    if missing := [key for key in ("unit", "limits", "typical") if key not in content]:
        raise OptionError(f"{where}: {missing[0]} is missing")
    _name(name, f"parameter in {where}")
    unit, limits = content["unit"], content["limits"]
    try:
        scale = inertia ** mass_in(str(unit))
    except ValueError:
        raise OptionError(
            f"{where}: unit is {quoted(unit)}; expected SI units: {', '.join(UNITS)}, as in N m s/rad or m^2"
        ) from None
    if not isinstance(limits, list) or len(limits) != 2:
        raise OptionError(f"{where}: limits is {quoted(limits)}; expected the lowest and the highest value")
    lower = number(limits[0], f"{where}: lower limit", -math.inf)
    upper = number(limits[1], f"{where}: upper limit", lower)
    typical = number(content["typical"], f"{where}: typical", lower, upper)
    if typical == 0.0 and lower < upper:
        raise OptionError(f"{where}: typical is 0; expected the size that such an effect usually has")
    width = number(content.get("prior_width", 0.0), f"{where}: prior_width", 0.0)
    shape, resolves = content.get("shape", not lower <= 0.0 <= upper), content.get("resolves", "")
    if not isinstance(shape, bool):
        raise OptionError(f"{where}: shape is {quoted(shape)}; expected true or false")
    begins = content.get("begins", [])
    if not isinstance(begins, list) or len(begins) > _MOST or (begins and not shape):
        raise OptionError(
            f"{where}: begins is {quoted(begins)}; expected at most {_MOST} values of a shape parameter in a list"
        )
    if resolves not in ("", "speed", "angle"):
        raise OptionError(f"{where}: resolves is {quoted(resolves)}; expected speed or angle")
    values = [number(value, f"{where}: begins", lower, upper) / scale for value in begins]
    lower, upper, typical, width = (value / scale for value in (lower, upper, typical, width))
    return EffectParameter(
        name, str(unit), lower, upper, typical, width,
        begins=tuple(map(repr, values)), shape=shape, resolves=resolves,
    )  # fmt: skip


def _checked(text: Any, masses: Mapping[str, int], where: str, expected: int | None = None) -> int:
    """Return how often a formula's unit has a mass; refuse one that is no formula of these words, or of other unit."""
    tree = parse(text, masses.keys(), where)
    found = _Masses(masses, where, text).of(tree)
    if expected is not None and found != expected:
        raise OptionError(
            f"{where}: its unit has a mass to the power of {found:g}, expected {expected}; numbers have no unit: name "
            "them as parameters, with units and equal limits"
        )
    return int(found)


class _Masses:
    """How often the units of a formula's parts have a mass."""

    def __init__(self, masses: Mapping[str, int], where: str, text: str) -> None:
        self._masses, self._where, self._text = masses, where, text

    def of(self, tree: Tree) -> float:
        """Return it for a part. Raises `OptionError` where the units of its parts do not go together."""
        if isinstance(tree, ast.Name):
            return self._masses.get(tree.id, 0)
        if isinstance(tree, ast.UnaryOp):
            return self.of(tree.operand)
        if isinstance(tree, ast.BinOp):
            return self._of_two(tree)
        if isinstance(tree, ast.Call):
            assert isinstance(tree.func, ast.Name)
            inside, function = self.of(tree.args[0]), tree.func.id
            if function in ("abs", "mean", "rate"):
                return inside
            if function == "sqrt":
                return inside / 2
            if inside and function not in ("sign", "step"):
                raise error_at(self._where, self._text, tree, f"{function} of what has a mass in its unit")
        return 0

    def _of_two(self, tree: ast.BinOp) -> float:
        left, right = self.of(tree.left), self.of(tree.right)
        if isinstance(tree.op, ast.Mult | ast.Div):
            return left + right if isinstance(tree.op, ast.Mult) else left - right
        if isinstance(tree.op, ast.Pow):
            if right or (left and not isinstance(tree.right, ast.Constant)):
                raise error_at(self._where, self._text, tree.right, "a power of what has a mass in its unit")
            return left * float(tree.right.value) if isinstance(tree.right, ast.Constant) else 0  # type: ignore[arg-type]
        if left != right:
            raise error_at(self._where, self._text, tree.right, "a sum of what has a mass in its unit and what has not")
        return left


def _name(name: Any, what: str) -> str:
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise OptionError(f"{what} is {quoted(name)}; expected small letters, digits and _, a letter first")
    return name
