# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The schema of `report.json`, read from `schema.md`: the one statement of what a report holds.

It is a JSON Schema (draft 2020-12), with a limit to everything that is repeated, since a report may come from anyone.
"""

import re
from pathlib import Path
from typing import Any

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

_Rows = list[tuple[int, re.Match[str]]]
"""Lines with how far they are indented."""


def _object(properties: dict[str, Schema], optional: tuple[str, ...] = ()) -> Schema:
    required = [name for name in properties if name not in optional]
    return {"type": "object", "properties": properties, "required": required, "additionalProperties": False}


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
    options = _object(values, tuple(name for name in KEYS if name not in required))
    return options | {"patternProperties": {f"^{re.escape(WEIGHTS)}": weight}}


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
        (depth, row), *rows = rows
        below = next((place for place, (other, _) in enumerate(rows) if other <= depth), len(rows))
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
        rows = re.findall(r"^ *- .*(?:\n *[^- \n].*)*", lines, re.MULTILINE)
        _KINDS[name] = _of_rows([_row(re.sub(r"\n *", " ", row)) for row in rows])


def _row(line: str) -> tuple[int, re.Match[str]]:
    row = _ROW.fullmatch(line)
    assert row, line
    return len(row[1]), row


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
