# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The code of laws is kept, found again, and made without sympy only where there is nothing to make."""

import os
import subprocess
import sys
from dataclasses import replace

import pytest

from cdp_ident.errors import OptionError
from cdp_ident.machine import compilation
from cdp_ident.model.effects.catalogue import CATALOGUE, NAMED
from cdp_ident.model.formulas import generated

EFFECTS = {effect.key: effect for effect in CATALOGUE}
SPRING = EFFECTS["joint_spring.inner"]
OTHER = replace(SPRING, law=replace(SPRING.law, torque="torque - stiffness*angle^3"))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where code is kept: nothing yet, and no module is loaded."""
    monkeypatch.setattr(compilation, "_CACHE_FOLDER", str(tmp_path))
    generated.module_of.cache_clear()
    yield tmp_path
    generated.module_of.cache_clear()


def test_code_is_made_once_and_kept(folder, monkeypatch):
    made = generated.module_of((SPRING,), paper=False)
    assert generated.module_of((SPRING,), paper=False) is made
    (file,) = folder.glob("laws_*.py")
    generated.module_of.cache_clear()
    monkeypatch.setattr(generated, "_text", None)  # nothing is made any more
    again = generated.module_of((SPRING,), paper=False)
    assert again.MOTION.keys() == {SPRING.key}
    assert file.read_text().startswith(again.text)


def test_another_formula_parameter_or_maker_is_other_code(folder, monkeypatch):
    digests = {generated._digest((effect,), False) for effect in (SPRING, OTHER)}
    digests.add(generated._digest((SPRING,), True))
    renamed = replace(SPRING.parameters[0], name="rate")
    digests.add(generated._digest((replace(SPRING, parameters=(renamed, SPRING.parameters[1])),), False))
    monkeypatch.setattr(generated, "_source", lambda name: b"another version")
    digests.add(generated._digest((SPRING,), False))
    assert len(digests) == 5
    described = replace(SPRING, description="the same", source="elsewhere")  # which changes no code
    assert generated._digest((described,), False) in digests


def test_damaged_code_is_made_anew(folder, monkeypatch):
    generated.module_of((SPRING,), paper=False)
    (file,) = folder.glob("laws_*.py")
    text = file.read_text()
    for damaged in ("", text[: len(text) // 2], text.replace("MOTION", "NOTION")):
        file.write_text(damaged)
        generated.module_of.cache_clear()
        assert generated.module_of((SPRING,), paper=False).MOTION.keys() == {SPRING.key}
        assert file.read_text() == text


def test_what_was_made_when_the_package_was_built_is_used_while_it_is_of_this_version(folder, monkeypatch, tmp_path):
    built = tmp_path / "built" / "laws.py"
    built.parent.mkdir()
    monkeypatch.setattr(generated, "BUILT", built)
    few = (SPRING,)
    generated.build(few)
    assert generated.module_of(few, paper=True).text == built.read_text()
    assert list(folder.glob("laws_*.py")) == []
    generated.module_of((OTHER,), paper=True)
    assert len(list(folder.glob("laws_*.py"))) == 1
    built.write_text(built.read_text().replace('DIGEST = "', 'DIGEST = "of another version '))
    generated.module_of.cache_clear()
    assert generated.module_of(few, paper=True).text != built.read_text()


def test_making_code_without_sympy_says_what_to_install(folder, monkeypatch):
    for name in ("code", "derivation"):
        monkeypatch.delitem(sys.modules, f"cdp_ident.model.formulas.{name}", raising=False)
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(OptionError, match="without sympy: pip install sympy"):
        generated.module_of((OTHER,), paper=False)


def test_code_that_is_there_is_used_without_sympy():
    used = "import sys; sys.modules['sympy'] = None; from cdp_ident.model.formulas.compiled import motion_law; "
    used += "from cdp_ident.model.effects.catalogue import NAMED; print(len({motion_law(effect) for effect in NAMED}))"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    generated.module_of(NAMED, paper=True)
    done = subprocess.run([sys.executable, "-c", used], env=environment, capture_output=True, text=True, check=True)
    assert int(done.stdout) > 20
