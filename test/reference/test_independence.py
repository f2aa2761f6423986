# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The reference is of use only as long as it shares nothing with what it is held against."""

import ast
from pathlib import Path

import reference

FOLDER = Path(reference.__file__).parent


def imported(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0
            yield node.module


def test_the_reference_imports_nothing_of_the_package():
    modules = sorted(FOLDER.rglob("*.py"))
    assert len(modules) > 10
    strangers = {path.name: set(imported(path)) for path in modules}
    owned = {"cdp_ident", "scenarios", "benchmarks", "test"}
    assert not {name: found for name, names in strangers.items() if (found := {n.split(".")[0] for n in names} & owned)}
