# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The words that stand beneath the fields of a dataclass, so that they need not be written a second time."""

import ast
import inspect
import re
import textwrap
from typing import Any

_UNIT = re.compile(r"\s*\[([^\]]+)\]")


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


def without_unit(description: str) -> tuple[str, str]:
    """Part a description into its words and the unit that stands in brackets in it; "" if there is none."""
    found = _UNIT.search(description)
    return (_UNIT.sub("", description, count=1), found[1]) if found else (description, "")
