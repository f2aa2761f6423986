# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of the library is made of modules that exist, and its example runs."""

import re
from importlib.util import find_spec
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "api.md").read_text(encoding="utf-8")


def test_modules_that_are_described_exist():
    modules = re.findall(r"^\.\. automodule:: (\S+)$", PAGE, re.MULTILINE)
    assert modules
    assert [module for module in modules if find_spec(module) is None] == []


def test_the_example_of_the_library_identifies_the_example_bags(monkeypatch, capsys):
    (example,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    monkeypatch.chdir(Path(__file__).parents[2])
    exec(compile(example, "api.md", "exec"), {})
    assert "a1_over_A22" in capsys.readouterr().out
