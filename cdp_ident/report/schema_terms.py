"""The terms in which the schema of `report.json` is stated: JSON Schema, with limits to everything that is repeated."""

from typing import Any

Schema = dict[str, Any]

LONGEST_TEXT = 4000
"""Letters of any text in a report."""
_LARGEST = 1e300
_MOST = 1000
"""Trials, effects, warnings and the like."""


def an_object(about: str = "", optional: tuple[str, ...] = (), /, **properties: Schema) -> Schema:
    """Return the schema of an object with these properties and no others; all but the `optional` ones must be there."""
    required = [name for name in properties if name not in optional]
    return {
        "type": "object",
        "description": about,
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


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


def a_pair(items: Schema, about: str = "") -> Schema:
    """Return the schema of a list of two."""
    return a_list(items, about, 2) | {"minItems": 2}


def points(items: Schema, about: str, length: int) -> Schema:
    """Return the schema of a list of just so many."""
    return a_list(items, about, length) | {"minItems": length}


def finite(about: str = "") -> Schema:
    """Return the schema of a number."""
    return {"type": "number", "description": about, "minimum": -_LARGEST, "maximum": _LARGEST}


def number(about: str = "") -> Schema:
    """Return the schema of a number, or null for one that is not finite."""
    return {"type": ["number", "null"], "description": about, "minimum": -_LARGEST, "maximum": _LARGEST}


def count(about: str = "") -> Schema:
    """Return the schema of a whole number that is not negative."""
    return {"type": "integer", "description": about, "minimum": 0, "maximum": 2**63 - 1}


def text(about: str = "") -> Schema:
    """Return the schema of a text."""
    return {"type": "string", "description": about, "maxLength": LONGEST_TEXT}


def one_of(words: tuple[str, ...], about: str = "") -> Schema:
    """Return the schema of one of some words."""
    return {"enum": list(dict.fromkeys(words)), "description": about}


def flag(about: str = "") -> Schema:
    """Return the schema of true or false."""
    return {"type": "boolean", "description": about}


def or_null(schema: Schema) -> Schema:
    """Return the schema of what a schema says, or null."""
    return {"anyOf": [schema, {"type": "null"}], "description": schema["description"]}
