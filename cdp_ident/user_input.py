# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Names and values that users give in files, options and parameters, checked."""

import difflib
import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, get_type_hints

from cdp_ident.errors import OptionError
from cdp_ident.outside_text import shown

_Kind = TypeVar("_Kind")

_LARGEST = sys.float_info.max
_LONGEST_NAME = 60


class Limits(NamedTuple):
    """What a user may give for a field of a dataclass, in the field's annotation: `Annotated[float, Limits(0, 1)]`."""

    minimum: float | None = None
    maximum: float | None = None
    changeable: bool = False
    """Whether it may change while a node runs."""


def limits_of(of: type) -> dict[str, Limits]:
    """Return the limits of each field of a dataclass."""
    hints = get_type_hints(of, include_extras=True)
    return {name: next(iter(getattr(hint, "__metadata__", ())), Limits()) for name, hint in hints.items()}


def quoted(value: Any) -> str:
    """Return what a user gave, as Python writes it, short and safe to be shown."""
    try:
        return shown(repr(value), _LONGEST_NAME)
    except ValueError:  # a whole number with more digits than Python writes
        return "a number of thousands of digits"


def number(value: Any, where: str, minimum: float, maximum: float = math.inf) -> float:
    """Return a number as a float. Raises `OptionError` where it is none, not finite, or out of its range."""
    usable = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST
    if not usable or not minimum <= value <= maximum:
        limit = f"at least {minimum:g}" if math.isinf(maximum) else f"{minimum:g} to {maximum:g}"
        raise OptionError(f"{where} is {quoted(value)}; expected a number, {limit}")
    return float(value) + 0.0  # -0.0 is 0.0


def user_path(text: str) -> Path:
    """Return the path that a user wrote, `~` for a home. Raises `OptionError` where there is no such home."""
    try:
        return Path(text).expanduser()
    except (RuntimeError, ValueError) as error:
        raise OptionError(f"{quoted(text)} is no path: {error}") from error


def refuse_unknown(names: Iterable[str], known: Iterable[str], where: str) -> None:
    """Raise an `OptionError` for the first of `names` that is not `known`; it tells the nearest known name.

    `where` says where the name stands, such as "parameter" or "key in 'rig.yaml'".
    """
    known = sorted(known)
    for name in names:
        if name not in known:
            raise OptionError(f"unknown {where}: {quoted(name)}; {_hint(str(name)[:_LONGEST_NAME], known)}")


def _hint(name: str, known: list[str]) -> str:
    nearest = [other for other in known if other.casefold() == name.casefold()]
    nearest = nearest or difflib.get_close_matches(name, known, n=1, cutoff=0.6)
    if nearest:
        return f"did you mean {nearest[0]!r}?"
    return f"known are {', '.join(known)}" if known else "none is known here"


def mapping_of(content: Any, where: str, known: Sequence[str] = ()) -> dict[str, Any]:
    """Return a mapping of a file. Raises `OptionError` where it is none, or has a key that is not `known`."""
    if not isinstance(content, dict):
        keys = f"keys ({', '.join(known)})" if known else "keys"
        raise OptionError(f"{where}: expected {keys} with values, found {quoted(content)}")
    if known:
        refuse_unknown(map(str, content), known, f"key in {where}")
    return content


def of_fields(content: Any, kind: type[_Kind], where: str) -> _Kind:
    """Return a dataclass of numbers that a mapping gives by the names of its fields; others have their defaults.

    Raises `OptionError` where a number is missing, unknown or out of its field's limits.
    """
    limits, types, values = limits_of(kind), get_type_hints(kind), {}
    given = mapping_of(content, where, tuple(limits))
    for part in fields(kind):  # type: ignore[arg-type]
        name = part.name
        if name in given:
            least, most, _ = limits[name]
            assert least is not None
            assert most is not None
            values[name] = types[name](number(given[name], f"{where}: {name}", least, most))
        elif part.default is MISSING:
            raise OptionError(f"{where}: {name} is missing")
    return kind(**values)
