"""The terms in which the schema of `report.json` is stated, and how what it states is taken from the package's types.

They are those of JSON Schema, with limits to everything that is repeated.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdp_ident.outside_text import shown

Schema = dict[str, Any]

LONGEST_TEXT = 4000
"""Letters of any text in a report."""
_LIMITS = {"minimum": -1e300, "maximum": 1e300}
_MOST = 1000
"""Trials, effects, warnings and the like."""
_UNIT = re.compile("_(rad|deg|s|percent)$")
"""What a key ends in, but no attribute."""


def _kind(**schema: Any) -> Callable[..., Schema]:
    """Return what makes the schema of one kind of value, given what it is about."""
    return lambda about="": {"description": about, **schema}


finite = _kind(type="number", **_LIMITS)
number = _kind(type=["number", "null"], **_LIMITS)
"""A number, or null for one that is not finite."""
count = _kind(type="integer", minimum=0, maximum=2**63 - 1)
text = _kind(type="string", maxLength=LONGEST_TEXT)
flag = _kind(type="boolean")


def an_object(about: str = "", optional: tuple[str, ...] = (), /, **properties: Schema) -> Schema:
    """Return the schema of an object with these properties and no others; all but the `optional` ones must be there."""
    return {
        "type": "object",
        "description": about,
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


def object_or_null(about: str, /, **properties: Schema) -> Schema:
    """Return the schema of an object with these properties, or null."""
    return or_null(an_object(about, **properties))


def objects(about: str = "", of_each: str = "", /, **properties: Schema) -> Schema:
    """Return the schema of a list of objects with these properties."""
    return a_list(an_object(of_each, **properties), about)


def a_map(values: Schema, about: str = "", names: Schema | None = None) -> Schema:
    """Return the schema of an object with names of its own."""
    return {
        "type": "object",
        "description": about,
        "additionalProperties": values,
        "propertyNames": names or {"maxLength": LONGEST_TEXT},
        "maxProperties": _MOST,
    }


def a_list(items: Schema, about: str = "", most: int = _MOST) -> Schema:
    """Return the schema of a list of at most so many."""
    return {"type": "array", "description": about, "items": items, "maxItems": most}


def points(items: Schema, about: str, length: int) -> Schema:
    """Return the schema of a list of just so many."""
    return a_list(items, about, length) | {"minItems": length}


def one_of(words: tuple[str, ...], about: str = "") -> Schema:
    """Return the schema of one of some words."""
    return {"enum": list(dict.fromkeys(words)), "description": about}


def or_null(schema: Schema) -> Schema:
    """Return the schema of what a schema says, or null."""
    return {"anyOf": [schema, {"type": "null"}], "description": schema["description"]}


@dataclass(frozen=True)
class Also:
    """Something to report, with values for keys that it has no attributes for, or others."""

    source: object
    values: Mapping[str, Any]


def filled(schema: Schema, source: Any) -> Any:
    """Return what a schema asks of something, as plain values whose texts are all fit to be shown.

    An object is filled from a mapping, from values in the order of its keys, or from the attributes that its keys name.
    """
    schema = schema.get("anyOf", [schema])[0]  # the other is null
    kind, keys = schema.get("type", ""), schema.get("properties")
    if "number" in kind and (source is not None or "null" in kind):
        return math.inf if source is None else float(source)
    if isinstance(source, str):
        return shown(source, LONGEST_TEXT)
    if source is not None and keys and not isinstance(source, Mapping):
        source = _values(source, list(keys))
    if isinstance(source, Mapping):
        schemas: dict[str, Schema] = keys or {}
        other: Schema = schema.get("additionalProperties") or {}
        return {shown(key, LONGEST_TEXT): filled(schemas.get(key, other), value) for key, value in source.items()}
    if isinstance(source, list | tuple):
        return [filled(schema.get("items", {}), value) for value in source]
    return source.tolist() if isinstance(source, np.ndarray | np.generic) else source


def _values(source: Any, keys: list[str]) -> Mapping[str, Any]:
    """Return the values of an object's keys."""
    if isinstance(source, np.ndarray) or type(source) in (list, tuple):
        return dict(zip(keys, source, strict=True))
    given: Mapping[str, Any] = {}
    if isinstance(source, Also):
        source, given = source.source, source.values
    return {key: given[key] if key in given else _attribute(source, key) for key in keys}


def _attribute(source: object, key: str) -> Any:
    return getattr(source, key if hasattr(source, key) else _UNIT.sub("", key))
