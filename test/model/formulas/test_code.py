# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The code that is made of formulas: plain Python, the same for the same formulas, and with no more than is needed."""

import ast
import re
from dataclasses import replace

import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE, NAMED, WRITTEN
from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State
from cdp_ident.model.formulas.algebra import FUNCTIONS
from cdp_ident.model.formulas.code import paper_text, text_of
from cdp_ident.model.formulas.language import CART, INNER, INPUTS, PARAMETERS, ROWS, VARIABLES
from scenarios.effects import EFFECTS

MINE = Effect(
    "mine", "outer", "my own", Law(torque="-size*bend", states=(State("bend", "speed/width"),), reading="size*angle"),
    (EffectParameter("size", "N m", 0.0, 1.0, 0.1), EffectParameter("width", "rad", 0.1, 1.0, 0.2, shape=True)), "me",
)  # fmt: skip

LAWS = f"{text_of(WRITTEN)}\n{paper_text()}"


def functions(text):
    return {node.name: node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)}


def computed(text, name, z, p, widths):
    """Return what a function of the code adds to the sums and sets in its rows, run as Python."""
    scope = {**FUNCTIONS}
    exec(text, scope)
    sums, rows = [0.0] * 3 * PARAMETERS, [0.0] * ROWS * widths
    scope[name](z, p, sums, rows)
    return sums, rows


def test_the_same_formulas_are_the_same_code_and_others_other_code():
    chosen = [EFFECTS[key] for key in ("air_drag.inner", "coulomb_friction.outer", "rod_flex.inner")]
    text = text_of(chosen)
    assert text_of(list(chosen)) == text
    changed = replace(chosen[0], law=replace(chosen[0].law, torques=("-coefficient*omega1", "")))
    assert text_of([changed, *chosen[1:]]) != text


def test_the_catalogue_s_code_is_plain_arithmetic():
    allowed = (
        ast.Assign, ast.AugAssign, ast.Expr, ast.Name, ast.Subscript, ast.Constant, ast.BinOp, ast.UnaryOp, ast.Call,
        ast.operator, ast.unaryop, ast.expr_context, ast.arguments, ast.arg,
        ast.FunctionDef, ast.Return, ast.Tuple,
    )  # fmt: skip
    for node in functions(LAWS).values():
        assert all(isinstance(part, allowed) for part in ast.walk(node))
    assert not re.search(r"\b(nan|inf|None)\b", LAWS)


def test_each_line_says_what_it_is():
    text = text_of([EFFECTS["coulomb_friction.outer"]])
    assert "# torque on theta1\n" in text
    assert "# torque on theta2 by torque\n" in text
    assert EFFECTS["coulomb_friction.outer"].formula in text


def test_what_a_law_does_not_do_is_not_computed():
    def written(effect):
        return set(map(int, re.findall(r"rows\[(\d+)\]", text_of([effect]))))

    width = PARAMETERS + 1
    assert written(EFFECTS["coulomb_friction.inner"]) == {PARAMETERS, 2 * width}
    assert written(EFFECTS["quadratic_friction.inner"]) == {PARAMETERS}
    base = replace(MINE, joint="base", law=Law(cart="-size*pull"), parameters=MINE.parameters[:1])
    assert written(base) == {CART * width + PARAMETERS}


def test_of_no_strength_there_are_derivatives_by_strengths_alone():
    text = text_of([EFFECTS["stribeck_friction.inner"], EFFECTS["backlash.inner"]])
    body = ast.unparse(functions(text)["stribeck_friction_inner_at_zero"])
    assert set(map(int, re.findall(r"rows\[(\d+)\]", body))) == {PARAMETERS, PARAMETERS + 1}
    z = [0.0] * len(INPUTS)
    z[VARIABLES.index("omega1")] = 0.2
    z[INPUTS.index("direction_inner")] = 1.0
    _, rows = computed(text, "stribeck_friction_inner_at_zero", z, [0.0, 0.0, 0.5], PARAMETERS + 3)
    assert rows[PARAMETERS : PARAMETERS + 3] == pytest.approx([-1.0, -0.8521437889662113, 0.0])
    _, rows = computed(text, "backlash_inner_at_zero", z, [0.0], PARAMETERS + 1)
    assert rows[INNER * (PARAMETERS + 1) + PARAMETERS] == -0.5


@pytest.mark.parametrize("name", ["reading_error", "off at_zero", "class"])
def test_what_a_law_is_called_changes_nothing_of_what_it_does(name):
    named = functions(text_of([replace(MINE, name=name)])).values()
    mine = functions(text_of([MINE])).values()
    assert [list(map(ast.unparse, one.body)) for one in named] == [list(map(ast.unparse, one.body)) for one in mine]


def test_laws_that_are_the_same_share_their_code_and_curves_have_none():
    harmonics = [effect for effect in NAMED if effect.name == "cogging_torque" and effect.joint == "inner"]
    text = text_of(harmonics)
    assert len(functions(text)) == 2  # of no strength, and of some
    assert not functions(text_of([effect for effect in CATALOGUE if effect.curve]))
