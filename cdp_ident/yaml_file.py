# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""YAML files that others wrote: the one place where they are read, within limits."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from cdp_ident.files import read_regular
from cdp_ident.outside_text import shown

LARGEST = 1 << 20
"""Bytes of a file; rigs, calibrations and parameter files have a few thousand."""
_MOST_NODES = 20_000
_DEEPEST = 32
_LONGEST_SCALAR = 4096


class _Loader(yaml.SafeLoader):
    """Plain values only: no alias, which can stand for any amount of data, and no tag, which can fail in any way."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._nodes = self._depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.peek_event()  # type: ignore[no-untyped-call]
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            raise yaml.MarkedYAMLError(problem="anchors and aliases are not taken", problem_mark=event.start_mark)
        if getattr(event, "tag", None) is not None:
            raise yaml.MarkedYAMLError(problem="tags are not taken", problem_mark=event.start_mark)
        if isinstance(event, yaml.ScalarEvent):
            if len(event.value) > _LONGEST_SCALAR:
                problem = f"a value of more than {_LONGEST_SCALAR} characters is not taken"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=event.start_mark)
            event.value.encode()  # "\ud800" is no text that can be written anywhere
        self._nodes += 1
        self._depth += 1
        if self._nodes > _MOST_NODES or self._depth > _DEEPEST:
            problem = f"more than {_MOST_NODES} values, or {_DEEPEST} one inside the other, are not taken"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=event.start_mark)
        node = super().compose_node(parent, index)
        self._depth -= 1
        if isinstance(node, yaml.MappingNode):
            _refuse_a_key_that_stands_twice(node)
        return node


def _refuse_a_key_that_stands_twice(mapping: yaml.MappingNode) -> None:
    """Raise MarkedYAMLError where one key hides another one, `a.b: 1` or `/a/b: 1` that of `a: {b: 2}`, too."""
    lines = dict[tuple[str, str], int]()
    for key, name in _keys(mapping):
        place, line = (key.tag, name.strip("/").replace("/", ".")), key.start_mark.line + 1
        if place in lines:
            problem = f"{name!r} stands twice, in line {lines[place]} and in line {line}: keep one"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=key.start_mark)
        lines[place] = line


def _keys(mapping: yaml.MappingNode, above: str = "") -> Iterator[tuple[yaml.ScalarNode, str]]:
    """Yield the keys of a mapping and of those in it, each with its name: after those above it, parted by dots."""
    for key, value in mapping.value:
        if isinstance(key, yaml.ScalarNode):
            yield key, above + key.value
            if isinstance(value, yaml.MappingNode):
                yield from _keys(value, f"{above}{key.value}.")


def read_yaml(path: Path) -> Any:
    """Return what a YAML file holds, as plain values.

    Raises OSError where it cannot be read, and ValueError, in one short line, where it is not YAML within the limits.
    """
    content = read_regular(path, LARGEST)
    try:
        return yaml.load(content.decode(), _Loader)
    except Exception as error:  # pyyaml's constructors raise whatever a value such as `2024-99-99` leads to
        raise ValueError(shown(error, 300)) from error
