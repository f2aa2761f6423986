# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the schema asks of a report is taken from the package's types."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdp_ident.outside_text import shown
from cdp_ident.report.schema import LONGEST_TEXT, Schema

_UNIT = re.compile("_(rad|deg|s|percent)$")
"""What a key ends in, but no attribute."""


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
