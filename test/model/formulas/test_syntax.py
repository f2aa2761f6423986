# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Formulas are read as arithmetic of known names, and whatever else is refused at its place."""

import math
from itertools import chain

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cdp_ident.errors import OptionError
from cdp_ident.model.effects.catalogue import NAMED
from cdp_ident.model.formulas.algebra import FUNCTIONS
from cdp_ident.model.formulas.language import OPERATORS
from cdp_ident.model.formulas.syntax import evaluated, names_used, parse

NAMES = ("speed", "angle", "torque", "omega1", "pi")
VALUES = {"speed": 2.0, "angle": -0.5, "torque": 3.0, "omega1": 7.0}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1", 1.0),
        ("-torque*speed", -6.0),
        ("+torque - -speed", 5.0),
        ("torque - speed - 1", 0.0),
        ("-speed^2", -4.0),
        ("speed^-torque", 0.125),
        ("2^speed^torque", 256.0),
        ("speed**2", 4.0),
        ("torque/speed/2", 0.75),
        ("1e-3*(speed\n + torque)", 5e-3),
        ("speed\n  + torque\n", 5.0),
        ("abs(angle) + sign(angle) + step(angle) + step(0)", 0.5),
        ("sin(pi/2)*cos(0) + tan(0)", 1.0),
        ("sqrt(exp(log(speed^2))) + atan(0) + tanh(0)", 2.0),
    ],
)
def test_a_formula_is_what_it_says(text, expected):
    parse(text, NAMES, "here")
    assert evaluated(text, VALUES) == pytest.approx(expected)


def test_every_function_is_read_and_known_by_its_value():
    for name in FUNCTIONS:
        parse(f"{name}(speed)", NAMES, "here")
        assert math.isfinite(evaluated(f"{name}(speed)", VALUES))


def test_a_mean_is_over_a_variable_that_is_known_within_it_alone():
    parse("mean(torque*place^2, place) + speed", NAMES, "here")
    with pytest.raises(OptionError, match=r"place is not known.*>>>place"):
        parse("mean(torque*place, place) + place", NAMES, "here")


def test_names_are_those_in_formulas_without_their_functions():
    assert names_used(["sin(angle)*x^2", "mean(y*place, place)"]) == {"angle", "x", "y", "place"}


REFUSED = {
    r"no arithmetic; at character 1": (
        "speed.real",  "[speed]", "[x for x in speed]", "speed[0]", "speed, angle",
        "speed if angle else 0", "speed < angle", "speed and angle", "not speed", "~speed",
    ),
    r"no arithmetic; at character": ("2*(1).__class__",),
    r"is no number": ("None", "True", "...", "2j*speed"),
    r"too large": ("1e400*speed", "10000000000000000"),
    r"the operator \w+ is not known; \+ - \* / \^ are": (
        "speed % 2", "speed // 2", "speed << 2", "speed | angle",
    ),
    r"the function \w+ is not known": ("__import__(1)", "eval(1)", "(sin)(speed)(angle)", "1 + open(speed)"),
    r"sin takes 1 argument;": ("sin()", "sin(speed, angle)", "sin(*speed)", "sin(x=speed)"),
    r"this is no formula; at character": (
        "speed = 1", "import os", "speed +", "(speed", "speed)", "2 speed", "speed^2 + angle^2 angle",
        "sin(" * 60 + "speed" + ")" * 59,
    ),
    r"no (arithmetic|formula)": ("await speed", "(yield)"),
    r"signs of arithmetic are read; at character \d": (
        "speed \N{MULTIPLICATION SIGN} 2", "speed\0", "speed # comment", "speed\\angle", "f'{speed}'", "lambda: 1",
        "(x := 1)", "speed @ angle", "eval('1')", "b'1'",
    ),
    r"expected a formula, found": ("", "  \n", 3.0, None),
    r"too many parts|no formula": ("1" + "+1" * 999, "-" * 1999 + "1", "1" + "^1" * 999),
    r"more than 60 brackets": ("(" * 61 + "1" + ")" * 61,),
    r"a formula of 2001 characters; at most 2000": ("1" + "+1" * 1000,),
    # The place is that in the formula as it was written, and the nearest known word is offered.
    r"velocity is not known; known are angle, omega1.* at character 10: torque \+ >>>vel": ("torque + velocity",),
    r"sped is not known; did you mean speed\?; at character 8: torque\*>>>sped": ("torque*sped",),
    r"at character 20: torque\^2 \+ angle\^2\*>>>sped": ("torque^2 + angle^2*sped",),
    r"sinh is not known; did you mean sin\?; at character 5": ("1 + sinh(speed)",),
    r"mean takes 2 arguments;": ("mean(speed)",),
    r"the variable of a mean is a name; at character 13": ("mean(speed, 2*place)",),
    r"at character 3: sp>>>éed": ("spéed",),
}  # fmt: skip


@pytest.mark.parametrize(("text", "message"), [(text, message) for message, of in REFUSED.items() for text in of])
def test_what_is_no_formula_is_refused_with_its_place(text, message):
    with pytest.raises(OptionError, match=f"^here: .*({message})"):
        parse(text, NAMES, "here")


SIGNS = "+-*/^()[]{},.:=<>!&|@%~'\"\\_# \n01e"
WORDS = [*NAMES, *FUNCTIONS, *OPERATORS, *SIGNS, "lambda", "if", "else", "for", "**", "^^"]


@given(st.one_of(st.text(max_size=60), st.lists(st.sampled_from(WORDS), max_size=30).map("".join)))
@example("1" + "+1" * 400)
@example("-" * 190 + "1")
def test_any_text_is_arithmetic_or_refused(text):
    try:
        parse(text, NAMES, "here")
    except OptionError:
        return
    assert names_used([text]) <= {*NAMES} or "mean" in text


def test_the_catalogue_s_formulas_use_names_alone_that_they_define_or_that_all_know():
    formulas = list(chain.from_iterable(effect.law.formulas.values() for effect in NAMED))
    assert len(formulas) >= len(NAMED)
    assert not any("__" in text for text in formulas)
