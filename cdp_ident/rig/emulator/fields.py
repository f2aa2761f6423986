# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Dataclasses from mappings of a rig's file: their fields say which numbers there are, and their limits."""

from dataclasses import MISSING, fields
from typing import Any, TypeVar, get_type_hints

from cdp_ident.errors import OptionError
from cdp_ident.user_input import limits_of, number, quoted, refuse_unknown

_Part = TypeVar("_Part")


def mapping(content: Any, where: str, known: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return a mapping of a rig's file. Raises `OptionError` where it is none, or has a key that is not `known`."""
    if not isinstance(content, dict):
        keys = f"keys ({', '.join(known)})" if known else "keys"
        raise OptionError(f"{where}: expected {keys} with values, found {quoted(content)}")
    if known:
        refuse_unknown(map(str, content), known, f"key in {where}")
    return content


def of_fields(content: Any, kind: type[_Part], where: str) -> _Part:
    """Return a dataclass of numbers that a mapping gives by the names of its fields; others have their defaults.

    Raises `OptionError` where a number is missing, unknown or out of its field's limits.
    """
    limits, types, values = limits_of(kind), get_type_hints(kind), {}
    given = mapping(content, where, tuple(limits))
    for field in fields(kind):  # type: ignore[arg-type]
        if field.name in given:
            least, most, _ = limits[field.name]
            assert least is not None
            assert most is not None
            values[field.name] = types[field.name](number(given[field.name], f"{where}: {field.name}", least, most))
        elif field.default is MISSING:
            raise OptionError(f"{where}: {field.name} is missing")
    return kind(**values)
