# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The example of docs/how_to/effect.md is followed in a copy of the package, and the effect that it adds is tried."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCUMENT = (ROOT / "docs/how_to/effect.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """Return a copy of what the example needs, with the effect added as the document says."""
    folder = tmp_path_factory.mktemp("copy")
    for name in ("cdp_ident", "reference", "scenarios", "test/model"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    effects = folder / "cdp_ident/model/effects"
    (effects / "hardening.py").write_text(_block("python"))
    catalogue = effects / "catalogue.py"
    text = catalogue.read_text()
    for diff in re.findall(r"```diff\n(.*?)```", DOCUMENT, re.DOTALL):
        before, after = (
            "".join(f"{line[1:]}\n" for line in diff.splitlines() if line[0] in kept) for kept in (" -", " +")
        )
        assert before in text
        text = text.replace(before, after)
    catalogue.write_text(text)
    return folder


def _block(language):
    found = re.search(rf"```{language}\n(.*?)```", DOCUMENT, re.DOTALL)
    assert found
    return found[1]


def test_the_catalogue_s_tests_try_it_and_pass(copy):
    (command,) = re.findall(r"(?m)^\.venv/bin/python -m (pytest .*)$", DOCUMENT)
    done = subprocess.run(
        [sys.executable, "-m", *command.split(), "-p", "no:cacheprovider", "-q"],
        cwd=copy, check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    passed = re.search(r"(\d+) passed", done.stdout)
    assert passed
    assert int(passed[1]) >= 6


def test_it_can_be_given_in_a_file_and_moves_a_pendulum(copy):
    program = """
from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.model.equilibria import EQUILIBRIA
from cdp_ident.model.linear import linearize
model = fitted_model({**NOMINAL, "effects.hardening_spring.outer.stiffness": 0.5}, "the example")
(active,) = model.motion.effects
print(active.effect.key, active.effect.description)
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=copy, check=False, capture_output=True, text=True)
    assert done.stdout == "hardening_spring.outer a cable that stiffens as it bends\n", done.stderr
