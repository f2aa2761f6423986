# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Formulas become expressions with their derivatives: means, rates along the paper's motion, kinks without impulses."""

import ast
import math

import numpy as np
import pytest
from scipy.integrate import quad

from cdp_ident.errors import OptionError
from cdp_ident.model.formulas.algebra import FUNCTIONS, as_number
from cdp_ident.model.formulas.derivation import Definitions
from cdp_ident.model.formulas.language import ACCELERATIONS, COEFFICIENTS, STATE
from cdp_ident.model.motions import accelerations_at, simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients

VALUES = dict(zip((*STATE, *ACCELERATIONS), (0.7, 2.1, -3.0, 4.5, 5.0, -7.0, 0.4), strict=True))
VALUES |= dict(zip(COEFFICIENTS, physical_coefficients(NOMINAL), strict=True))
VALUES |= {"size": 0.3, "width": 0.8, "direction_inner": -1.0, "direction_outer": 1.0, "t": 2.0, "outer_length": 0.42}
VALUES |= {"carried": 0.05}
STATE_THERE = np.array([[VALUES[name] for name in STATE]])
A1, L, M2_L2 = VALUES["a1"], VALUES["L"], VALUES["A23"] / VALUES["L"]


def definitions(joint="outer", **where):
    made = Definitions("here", joint)
    for name in ("size", "width"):
        made.add_input(name)
    for name, text in where.items():
        made.add(name, text)
    return made


def number(made, tree, values=VALUES):
    """Return the number that a tree is, computed as compiled code does it: one definition after the other."""
    known = values | {"pi": math.pi} | FUNCTIONS
    for k, theta in ((1, values["theta1"]), (2, values["theta2"])):
        known |= {f"sin{k}": math.sin(theta), f"cos{k}": math.cos(theta)}
    for name, definition in made.needed([tree]).items():
        known[name] = eval(ast.unparse(definition), {}, known)
    return float(eval(ast.unparse(tree), {}, known))


def value_of(text, joint="outer", values=VALUES, **where):
    made = definitions(joint, **where)
    return number(made, made.value("it", text), values)


@pytest.mark.parametrize(
    ("text", "joint", "expected"),
    [
        ("angle", "inner", 0.7 - math.pi),
        ("angle", "outer", 1.4),
        ("speed*acceleration", "outer", -90.0),
        ("direction", "inner", -1.0),
        ("direction", "outer", 1.0),
        ("sin(theta1 - theta2)", "base", math.sin(-1.4)),
        ("cos(theta2 - theta1) + sin(theta1 - 2*theta2)", "base", math.cos(1.4) + math.sin(-3.5)),
        ("m2_l2*L - A23", "base", 0.0),
        ("pull", "base", A1 * (5.0 * math.cos(0.7) - 9.0 * math.sin(0.7))
         + M2_L2 * (-7.0 * math.cos(2.1) - 20.25 * math.sin(2.1))),
        ("step(speed) + 2*step(-speed)", "inner", 2.0),
        ("sign(speed)*abs(speed)^1.5", "inner", -(3.0**1.5)),
    ],
)  # fmt: skip
def test_a_joint_s_own_words_and_those_of_both_rods_are_known(text, joint, expected):
    assert value_of(text, joint) == pytest.approx(expected, abs=1e-12)


def test_a_base_has_no_angle_of_its_own():
    with pytest.raises(OptionError, match=r"^here: it: angle is not known"):
        value_of("angle", "base")


def test_the_paper_s_own_motion_is_known():
    free = accelerations_at(np.array([VALUES[name] for name in COEFFICIENTS]), STATE_THERE, np.zeros(1))[0]
    assert [value_of(f"free{k}") for k in (1, 2)] == pytest.approx(free, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "exact"),
    [
        ("mean((width*place + 1)^3, place)", lambda place: (0.8 * place + 1.0) ** 3),
        ("mean(place*across*abs(across), place)", lambda place: place * (2.0 + 4.5 * place) * abs(2.0 + 4.5 * place)),
        ("mean(cos(place*angle)*size, place)", lambda place: 0.3 * math.cos(1.4 * place)),
    ],
)
def test_a_mean_is_the_integral_over_its_variable(text, exact):
    found = value_of(text, across="2 + place*omega2")
    assert found == pytest.approx(quad(exact, 0.0, 1.0)[0], rel=1e-7)


@pytest.mark.parametrize("text", ["sin(angle)*speed", "a1*omega1^2*cos(theta1 - theta2)", "free1*size", "omega2*t"])
def test_a_rate_is_that_along_the_motion_of_the_paper_s_model(text):
    coefficients, step = np.array([VALUES[name] for name in COEFFICIENTS]), 1e-4
    moved = simulate(coefficients, STATE_THERE[0], step * np.arange(3), None, step)
    here, ahead, further = (
        value_of(text, values=VALUES | dict(zip(STATE, state, strict=True)) | {"t": VALUES["t"] + k * step})
        for k, state in enumerate(moved)
    )
    assert value_of(f"rate({text})") == pytest.approx((4.0 * ahead - further - 3.0 * here) / (2.0 * step), rel=1e-4)
    # Rates may be of rates, and of what never changes.
    assert value_of("rate(rate(theta1))") == pytest.approx(value_of("free1"))
    assert value_of("rate(size*L)") == 0.0


FORMULAS = [
    "size*exp(-(speed/width)^2)*angle",
    "abs(speed)*speed + sqrt(1 + angle^2)*log(2 + cos(angle)) - atan(u/width)",
    "mean((size + place*omega1)*abs(size + place*omega1), place)",
    "size*tanh(pull)*tan(theta1/2)",
    "rate(rate(m2_l2*sin(theta2)))*size",
    "twice^2 + twice",
    "(2 + sin(theta1))^width/outer_length + carried*alpha2*t",
]


@pytest.mark.parametrize("text", FORMULAS)
def test_slopes_are_those_of_differences(text):
    made = definitions(twice="2*sin(theta1 - theta2)*width")
    value = made.value("it", text)
    for name in (*STATE, *ACCELERATIONS, *COEFFICIENTS, "size", "width"):
        step = 1e-6 * max(1.0, abs(VALUES[name]))
        sides = [number(made, value, VALUES | {name: VALUES[name] + side * step}) for side in (1, -1)]
        expected = (sides[0] - sides[1]) / (2.0 * step)
        assert number(made, made.slope(value, name)) == pytest.approx(expected, rel=1e-6, abs=1e-6), name


@pytest.mark.parametrize("text", ["abs(omega1)", "sign(omega1)", "step(omega1)", "omega1*abs(omega1)"])
def test_a_kink_has_no_impulse_and_no_slope_that_is_no_number(text):
    made = definitions()
    slope = made.slope(made.value("it", text), "omega1")
    assert number(made, slope, VALUES | {"omega1": 0.0}) == 0.0
    assert as_number(made.slope(made.value("other", "size*speed"), "L")) == 0  # on which it does not depend


def test_a_definition_is_made_once_and_needed_ones_come_in_their_order():
    made = definitions(twice="2*sin(2*angle)", more="twice + twice^2 + sin(2*angle)")
    needed = made.needed([made.value("it", "more*twice"), made.value("other", "more")])
    names = list(needed)
    assert sorted(names) == sorted(set(names))
    assert names.index("twice") < names.index("more") < names.index("it")
    assert sum("sin(" in ast.unparse(tree) for tree in needed.values()) == 1


@pytest.mark.parametrize(
    ("text", "longest"),
    [("size" + "*(1 + speed)" * 60, 2e3), ("rate(rate(size" + "/(1 + angle^2)" * 60 + "))", 1e5)],
    ids=["once", "three times differentiated"],
)
def test_a_long_formula_is_put_together_of_short_definitions(text, longest):
    made = definitions()
    value = made.value("it", text)
    needed = made.needed([value, *(made.slope(value, name) for name in STATE)])
    assert max(len(ast.unparse(tree)) for tree in needed.values()) < longest
    sides = [value_of(text, values=VALUES | {"theta2": VALUES["theta2"] + side * 1e-6}) for side in (1, -1)]
    expected = (sides[0] - sides[1]) / 2e-6
    assert number(made, made.slope(value, "theta2")) == pytest.approx(expected, rel=1e-6, abs=1e-12)


def test_where_names_have_given_values_what_is_then_not_needed_is_left_out():
    made = definitions(shape="exp(-(speed/width)^2)")
    value = made.value("it", "size*shape")
    results, needed = made.given({"it": value, "by": made.slope(value, "size")}, {"size": 0})
    assert as_number(results["it"]) == 0
    assert number(made, results["by"]) == pytest.approx(math.exp(-((7.5 / 0.8) ** 2)), rel=1e-9)
    assert "it" not in needed


@pytest.mark.parametrize(
    ("text", "where", "message"),
    [
        ("sise*speed", {}, r"^here: it: sise is not known; did you mean size\?"),
        ("part*speed", {"part": "2*unheard"}, r"unheard is not known"),
        ("direction_middle", {}, "not known"),
    ],
)
def test_unknown_names_are_refused_where_they_stand(text, where, message):
    with pytest.raises(OptionError, match=message):
        value_of(text, **where)


@pytest.mark.parametrize("text", ["size/0", "0^-1", "log(0)*size", "sqrt(-1)", "size*log(-2)", "(-8)^(1/3)", "9^9^6"])
def test_what_is_no_real_number_or_none_that_is_finite_is_refused(text):
    with pytest.raises(OptionError, match=r"^here: it\b"):
        value_of(text)
