"""The terms in which the schema of `report.json` is stated: JSON Schema, with limits to everything that is repeated."""

from collections.abc import Callable
from typing import Any

Schema = dict[str, Any]

LONGEST_TEXT = 4000
"""Letters of any text in a report."""
_LIMITS = {"minimum": -1e300, "maximum": 1e300}
_MOST = 1000
"""Trials, effects, warnings and the like."""


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
