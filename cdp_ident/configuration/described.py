# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Values with names and words: settings, results and parameters of nodes, as users see them."""

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args, get_origin, get_type_hints

from cdp_ident.user_input import limits_of

_UNIT = re.compile(r"\s*\[([^\]]+)\]")


@dataclass(frozen=True)
class Described:
    """A value with all that is said of it."""

    name: str
    value: Any
    """A number, text, truth value or a list of one of these; of a setting its default, None for a number that is not
    set, or follows from others."""
    description: str
    unit: str = ""
    minimum: float | None = None
    """Lowest possible value; None where there is none, or the value may be infinite, which no range can hold."""
    maximum: float | None = None
    choices: Sequence[str] = ()
    changeable: bool = False
    """Whether others may set it while a node runs; it is read only to them if not."""

    @property
    def constraint(self) -> str:
        """In words, what values are allowed."""
        if self.choices:
            return f"one of: {', '.join(self.choices)}"
        low = "" if self.minimum is None else f"at least {self.minimum:g}"
        high = "" if self.maximum is None else f"at most {self.maximum:g}"
        interval = " and ".join(filter(None, (low, high)))
        return f"{interval} {self.unit}".rstrip() if interval else ""


def described_fields(of: Any, prefix: str = "") -> Iterator[Described]:
    """Describe the values of a dataclass by the words beneath each field, and by what its annotation allows."""
    words, limits, kinds = field_documentation(type(of)), limits_of(type(of)), get_type_hints(type(of))
    for field in fields(of):
        if field.name in words:
            unit = _UNIT.search(words[field.name])
            yield Described(
                prefix + field.name,
                getattr(of, field.name),
                _UNIT.sub("", words[field.name], count=1),
                unit[1] if unit else "",
                *limits[field.name][:2],
                get_args(kinds[field.name]) if get_origin(kinds[field.name]) is Literal else (),
                limits[field.name].changeable,
            )


def field_documentation(of: type[Any]) -> dict[str, str]:
    """Return the first paragraph of the docstring beneath each field that has one, as one line without full stop."""
    body = ast.parse(textwrap.dedent(inspect.getsource(of))).body[0]
    assert isinstance(body, ast.ClassDef)
    documentation = {}
    for field, after in zip(body.body, body.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(after, ast.Expr):
            text = ast.literal_eval(after.value)
            documentation[field.target.id] = " ".join(inspect.cleandoc(text).split("\n\n")[0].split()).rstrip(".")
    return documentation
