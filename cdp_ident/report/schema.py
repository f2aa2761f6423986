# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The schema of `report.json`, read from `schema.md`: the one statement of what a report holds, and what fills it.

It is a JSON Schema (draft 2020-12), with a limit to everything that is repeated, since a report may come from anyone.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jsonschema import Draft202012Validator

from cdp_ident.configuration.settings import KEYS, WEIGHTS
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.parameters import CONSTANTS, GROUPS, SYMBOLS
from cdp_ident.outside_text import shown

Section = dict[str, Any]
"""A report, or a part of one."""
Schema = dict[str, Any]

LONGEST_TEXT = 4000
"""Letters of any text in a report."""
_MOST = 1000
"""Trials, effects, warnings and the like."""
_LIMITS = {"minimum": -1e300, "maximum": 1e300}
_IDENTIFIER = {"pattern": "^[a-z][a-z0-9_]{0,60}$"}
_KEYS = {"symbol": SYMBOLS, "base parameter": tuple(group.symbol for group in GROUPS), "joint": JOINTS}
"""What stands for several keys."""
_NAMES = {"name": {"maxLength": LONGEST_TEXT}, "identifier": _IDENTIFIER}
"""Keys of an object that has any."""
_ROW = re.compile(r"( *)- (?:each (?P<each>[a-z ]+)|(?P<keys>`[^(:]+?))(?: \((?P<kind>.+?)\))?(?:: (?P<about>.+))?")
_LIST = re.compile(r"lists?(?: of (?:(at most|exactly) (\d+) )?(.+))?")
_UNIT = re.compile("_(rad|deg|s|percent)$")
"""What a key ends in, but no attribute."""

_Rows = list[re.Match[str]]
"""Lines; the first group is how far they are indented."""


def _object(properties: dict[str, Schema]) -> Schema:
    return {"type": "object", "properties": properties, "required": [*properties], "additionalProperties": False}


def _options() -> Schema:
    """Return the schema of the settings; those that have no fixed value may be missing."""
    kinds = {bool: _KINDS["flag"], int: _KINDS["count"], float: _KINDS["number"], str: _KINDS["text"]}
    none = {"anyOf": [_KINDS["finite number"], {"type": "null"}]}
    required = (*(constant.symbol for constant in CONSTANTS), *(f"nominal.{symbol}" for symbol in SYMBOLS))
    weight = {"type": "array", "items": _KINDS["finite number"], "maxItems": 3}
    values = {
        name: (none if key.value is None else kinds[type(key.value)]) | {"description": key.description}
        for name, key in KEYS.items()
    }
    of_weights = {"patternProperties": {f"^{re.escape(WEIGHTS)}": weight}}
    return _object(values) | {"required": [name for name in KEYS if name in required]} | of_weights


_KINDS: dict[str, Schema] = {
    "finite number": {"type": "number", **_LIMITS},
    "number": {"type": ["number", "null"], **_LIMITS},
    "count": {"type": "integer", "minimum": 0, "maximum": 2**63 - 1},
    "text": {"type": "string", "maxLength": LONGEST_TEXT},
    "flag": {"type": "boolean"},
    "effect's name": {"type": "string", "maxLength": LONGEST_TEXT, **_IDENTIFIER},
    "definition": {"type": "object"},
}
_KINDS["options"] = _options()


def _of_kind(kind: str, inside: _Rows) -> Schema:
    """Return the schema of a kind of value, which may have values inside."""
    kind, *null = kind.split(" or null")
    if null:
        return {"anyOf": [_of_kind(kind, inside), {"type": "null"}]}
    if kind.startswith("`"):
        return {"enum": re.findall("`(.+?)`", kind)}
    if found := _LIST.fullmatch(kind):
        size, most, items = found.groups("")
        schema = {"type": "array", "items": _of_kind(items or "object", inside), "maxItems": int(most or _MOST)}
        return schema | {"minItems": int(most)} if size == "exactly" else schema
    if kind == "object":
        return _of_rows(inside)
    return _KINDS[kind if kind in _KINDS else kind.removesuffix("s")]


def _of_rows(rows: _Rows) -> Schema:
    """Return the schema of an object of which each value has a line, with others below it for what is inside."""
    properties: dict[str, Schema] = {}
    while rows:
        row, *rows = rows
        below = next((place for place, other in enumerate(rows) if len(other[1]) <= len(row[1])), len(rows))
        value = _of_kind(row["kind"] or "object", rows[:below]) | {"description": row["about"] or ""}
        rows = rows[below:]
        if row["each"] in _NAMES:
            names = _NAMES[row["each"]]
            return {"type": "object", "additionalProperties": value, "propertyNames": names, "maxProperties": _MOST}
        keys = _KEYS[row["each"]] if row["each"] else re.findall("`(.+?)`", row["keys"])
        properties |= dict.fromkeys(map(str, keys), value)
    return _object(properties)


def _read() -> None:
    """Read the kinds that are stated; each stands before those that it is made of."""
    _, *stated = Path(__file__).with_suffix(".md").read_text(encoding="utf-8").split("\n## ")
    for kind in reversed(stated):
        name, _, lines = kind.partition("\n")
        rows = [re.sub(r"\n *", " ", row) for row in re.findall(r"^ *- .*(?:\n *[^- \n].*)*", lines, re.MULTILINE)]
        read = [row for row in map(_ROW.fullmatch, rows) if row]
        assert len(read) == len(rows), name
        _KINDS[name] = _of_rows(read)


_read()
REPORT, ADVICE = _KINDS["report"], _KINDS["start"]
(SCHEMA,) = REPORT["properties"]["schema"]["enum"]
_VALIDATOR = Draft202012Validator(REPORT)


def problem(content: Any) -> str:
    """Return what of a report contradicts the schema, and where, in one short line; empty if nothing does."""
    error = next(iter(_VALIDATOR.iter_errors(content)), None)
    if error is None:
        return ""
    place = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.absolute_path)
    return f"{shown(place.lstrip('.'), 200) or 'it'}: {shown(error.message, 200)}"


@dataclass(frozen=True)
class Also:
    """Something to report, with values for keys that it has no attributes for, or others."""

    source: object
    values: Mapping[str, Any]


def filled(schema: Schema, source: Any) -> Any:
    """Return what a schema asks of something, as plain values whose texts are all fit to be shown.

    An object is filled from a mapping, from values in the order of its keys, or from the attributes that its keys name,
    with their units or without. A number that is missing is infinite.
    """
    schema = schema.get("anyOf", [schema])[0]  # the other is null
    kind, keys = schema.get("type", ""), schema.get("properties")
    if "number" in kind and (source is not None or "null" in kind):
        return math.inf if source is None else float(source)
    if isinstance(source, str):
        return shown(source, LONGEST_TEXT)
    if source is not None and keys and not isinstance(source, Mapping):
        source = _values(source, keys)
    if isinstance(source, Mapping):
        schemas: dict[str, Schema] = keys or {}
        other: Schema = schema.get("additionalProperties") or {}
        return {shown(key, LONGEST_TEXT): filled(schemas.get(key, other), value) for key, value in source.items()}
    if isinstance(source, list | tuple):
        return [filled(schema.get("items", {}), value) for value in source]
    return source.tolist() if isinstance(source, np.ndarray | np.generic) else source


def _values(source: Any, keys: Mapping[str, Schema]) -> Mapping[str, Any]:
    """Return the values of an object's keys."""
    if isinstance(source, np.ndarray) or type(source) in (list, tuple):
        return dict(zip(keys, source, strict=True))
    source, given = (source.source, source.values) if isinstance(source, Also) else (source, {})
    return {
        key: given[key] if key in given else getattr(source, key if hasattr(source, key) else _UNIT.sub("", key))
        for key in keys
    }
