# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The subpackages import each other only as docs/explanation/architecture.md has it; one of them knows effects."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE

ROOT = Path(__file__).parents[1]
DOCUMENT = (ROOT / "docs" / "explanation" / "architecture.md").read_text(encoding="utf-8")


def test_the_import_rules_hold():
    pytest.importorskip("importlinter")
    # In a process of its own: what it writes goes around pytest's capture, and closes it.
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports; exit(lint_imports(no_cache=True))"]
    done = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_subpackage_is_in_the_document():
    subpackages = {path.parent.name for path in (ROOT / "cdp_ident").glob("*/__init__.py")}
    assert set(re.findall(r"(?m)^\| `(\w+)` \|", DOCUMENT)) == subpackages


def test_every_subpackage_is_in_the_rules():
    rules = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    layers = set(
        re.findall(r"cdp_ident\.(\w+)", rules[rules.index("layers = [") : rules.index("]", rules.index("layers = ["))])
    )
    package = ROOT / "cdp_ident"
    modules = {path.stem for path in package.glob("*.py")} - {"__init__"}
    assert layers == modules | {path.parent.name for path in package.glob("*/__init__.py")}


def test_the_types_that_are_handed_on_are_where_the_document_says():
    handed_on = re.findall(r"`(\w+)` \(`([\w/]+\.py)`\)", DOCUMENT)
    assert len(handed_on) > 5
    for name, path in handed_on:
        assert re.search(rf"(?m)^(class|def) {name}\b|^{name} = ", (ROOT / "cdp_ident" / path).read_text()), (
            name,
            path,
        )


def test_no_effect_is_known_by_its_name_outside_its_entry():
    package = ROOT / "cdp_ident"
    names = {name for effect in CATALOGUE for name in (effect.name, effect.key)}
    entries = package / "model" / "effects"
    for path in package.rglob("*.py"):
        if entries in path.parents:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                parts = node.value.split(".")
                known = names & {".".join(parts[:count]) for count in range(1, len(parts) + 1)}
                assert not known, f"{path}:{node.lineno} knows {known}"


def test_no_function_takes_more_than_ten_parameters():
    """What is looked at by its place in an argument list could be exchanged unnoticed, above all in compiled code."""
    for path in (ROOT / "cdp_ident").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                assert len(node.args.args) + len(node.args.kwonlyargs) <= 10, f"{path}:{node.lineno} {node.name}"
