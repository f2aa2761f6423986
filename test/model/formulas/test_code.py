# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The code that is made of formulas: plain Python, the same for the same formulas, and with no more than is needed.

It is kept, found again, and made without sympy only where there is nothing to make.
"""

import ast
import os
import re
import subprocess
import sys
from dataclasses import replace

import pytest

from cdp_ident.errors import OptionError
from cdp_ident.machine import compilation
from cdp_ident.model.effects.catalogue import CATALOGUE, NAMED, WRITTEN
from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State
from cdp_ident.model.formulas import generated
from cdp_ident.model.formulas.code import module_text
from cdp_ident.model.formulas.compiled import _CATALOGUE as LAWS
from cdp_ident.model.formulas.language import CART, INPUTS, PARAMETERS, VARIABLES
from scenarios.effects import EFFECTS

MINE = Effect(
    "mine", "outer", "my own", Law(torque="-size*bend", states=(State("bend", "speed/width"),), reading="size*angle"),
    (EffectParameter("size", "N m", 0.0, 1.0, 0.1), EffectParameter("width", "rad", 0.1, 1.0, 0.2, shape=True)), "me",
)  # fmt: skip


def functions(text):
    return {node.name: node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)}


def computed(text, name, z, p, widths):
    """Return what a function of the code adds to the sums and sets in its rows, run as Python."""
    scope = {}
    exec(text, scope)
    sums, rows = [0.0] * 3 * PARAMETERS, [0.0] * 6 * widths
    scope[name](z, p, sums, rows)
    return sums, rows


def test_the_same_formulas_are_the_same_code_and_others_other_code():
    chosen = [EFFECTS[key] for key in ("air_drag.inner", "coulomb_friction.outer", "rod_flex.inner")]
    text = module_text(chosen, "0123", paper=True)
    assert module_text(list(chosen), "0123", paper=True) == text
    assert 'DIGEST = "0123"' in text
    changed = replace(chosen[0], law=replace(chosen[0].law, torques=("-coefficient*omega1", "")))
    assert module_text([changed, *chosen[1:]], "0123", paper=True) != text


def test_the_catalogue_s_code_is_plain_arithmetic():
    allowed = (
        ast.Assign, ast.AugAssign, ast.Expr, ast.Name, ast.Subscript, ast.Constant, ast.BinOp, ast.UnaryOp, ast.Call,
        ast.IfExp, ast.Compare, ast.operator, ast.unaryop, ast.cmpop, ast.expr_context, ast.arguments, ast.arg,
        ast.FunctionDef, ast.Return, ast.Tuple,
    )  # fmt: skip
    for node in functions(LAWS.text).values():
        assert all(isinstance(part, allowed) for part in ast.walk(node))
    assert not re.search(r"\b(nan|zoo|oo|I|DiracDelta|Derivative|None)\b", LAWS.text)


def test_each_line_says_what_it_is():
    text = module_text([EFFECTS["coulomb_friction.outer"]], "", paper=False)
    assert "# torque on theta1\n" in text
    assert "# torque on theta2 by torque\n" in text
    assert EFFECTS["coulomb_friction.outer"].formula in text


def test_what_a_law_does_not_do_is_not_computed():
    def written(effect):
        return set(map(int, re.findall(r"rows\[(\d+)\]", module_text([effect], "", paper=False))))

    width = PARAMETERS + 1
    assert written(EFFECTS["coulomb_friction.inner"]) == {PARAMETERS, 2 * width}
    assert written(EFFECTS["quadratic_friction.inner"]) == {PARAMETERS}
    base = replace(MINE, joint="base", law=Law(cart="-size*pull"), parameters=MINE.parameters[:1])
    assert written(base) == {CART * width + PARAMETERS}


def test_of_no_strength_there_are_derivatives_by_strengths_alone():
    text = module_text([EFFECTS["stribeck_friction.inner"], EFFECTS["backlash.inner"]], "", paper=False)
    body = ast.unparse(functions(text)["stribeck_friction_inner_motion_at_zero"])
    assert set(map(int, re.findall(r"rows\[(\d+)\]", body))) == {PARAMETERS, PARAMETERS + 1}
    z = [0.0] * len(INPUTS)
    z[VARIABLES.index("omega1")] = 0.2
    z[INPUTS.index("direction_inner")] = 1.0
    _, rows = computed(text, "stribeck_friction_inner_motion_at_zero", z, [0.0, 0.0, 0.5], PARAMETERS + 3)
    assert rows[PARAMETERS : PARAMETERS + 3] == pytest.approx([-1.0, -0.8521437889662113, 0.0])
    _, rows = computed(text, "backlash_inner_reading_at_zero", z, [0.0], PARAMETERS + 1)
    assert rows[PARAMETERS] == -0.5


@pytest.mark.parametrize("name", ["reading_error", "off at_zero", "class"])
def test_what_a_law_is_called_changes_nothing_of_what_it_does(name):
    named = functions(module_text([replace(MINE, name=name)], "", paper=False)).values()
    mine = functions(module_text([MINE], "", paper=False)).values()
    assert [list(map(ast.unparse, one.body)) for one in named] == [list(map(ast.unparse, one.body)) for one in mine]


def test_laws_that_are_the_same_share_their_code_and_curves_have_none():
    harmonics = [effect for effect in NAMED if effect.name == "cogging_torque" and effect.joint == "inner"]
    text = module_text(harmonics, "", paper=False)
    assert len(functions(text)) == 2  # of no strength, and of some
    assert text.count('": cogging_torque_inner_motion,') == len(harmonics)
    assert not functions(module_text([effect for effect in CATALOGUE if effect.curve], "", paper=False))


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


def test_the_code_that_is_made_when_the_package_is_built_is_that_which_is_used():
    assert f'DIGEST = "{generated._digest(WRITTEN, paper=True)}"' in LAWS.text


def test_making_code_without_sympy_says_what_to_install(folder, monkeypatch):
    for name in ("code", "derivation"):
        monkeypatch.delitem(sys.modules, f"cdp_ident.model.formulas.{name}", raising=False)
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(OptionError, match="without sympy: pip install sympy"):
        generated.module_of((OTHER,), paper=False)


def test_code_that_is_there_is_used_without_sympy():
    used = "import sys; sys.modules['sympy'] = None; from cdp_ident.model.formulas.compiled import motion_law; "
    used += "from cdp_ident.model.effects.catalogue import WRITTEN; "
    used += "print(len({motion_law(effect) for effect in WRITTEN}))"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    generated.module_of(WRITTEN, paper=True)
    done = subprocess.run([sys.executable, "-c", used], env=environment, capture_output=True, text=True, check=True)
    assert int(done.stdout) > 20
