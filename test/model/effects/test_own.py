# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws that a user gives in a file are taken as they are meant, or refused with the place of what is wrong."""

import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import OptionError
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects import own
from cdp_ident.model.effects.catalogue import CATALOGUE, forget_own, known_effects
from cdp_ident.model.motions import accelerations_at
from cdp_ident.model.parameters import NOMINAL, physical_coefficients

A22 = 0.04
STIFFNESS = {"unit": "N m/rad", "limits": [0, 10], "typical": 0.1}


@pytest.fixture(autouse=True)
def _catalogue_alone():
    yield
    forget_own()


def cable(**changed):
    return {"cable": {"joint": "outer", "torque": "-k*angle", "parameters": {"k": STIFFNESS}} | changed}


def refusal(definitions):
    with pytest.raises(OptionError) as error:
        own.use(definitions, A22, "mine.yaml")
    assert known_effects() == CATALOGUE
    return str(error.value)


def test_a_law_acts_like_the_same_one_of_the_catalogue():
    own.use(cable(), A22, "mine.yaml")
    effect = known_effects()[-1]
    spring = next(e for e in CATALOGUE if e.key == "joint_spring.outer")
    states = np.array([[2.0, 3.0, 1.0, -1.0], [0.5, -2.0, 0.0, 3.0]])
    mine, theirs = (
        accelerations_at(physical_coefficients(NOMINAL), states, np.zeros(2), ActingEffects.of([(e, values)], 0.3))
        for e, values in ((effect, [0.7]), (spring, [0.7, 0.0]))
    )
    np.testing.assert_allclose(mine, theirs, rtol=1e-12)


def test_limits_are_physical_and_torques_over_a22_in_the_model():
    (effect,) = own.effects_of(cable(), A22, "mine.yaml")
    (k,) = effect.parameters
    assert (k.lower, k.upper, k.typical) == (0.0, 10.0 / A22, 0.1 / A22)
    assert k.scale(A22) == A22


def test_each_joint_of_a_list_has_it():
    effects = own.effects_of(cable(joint=["inner", "outer"]), A22, "mine.yaml")
    assert [effect.key for effect in effects] == ["cable.inner", "cable.outer"]


def test_a_definition_is_the_same_after_it_was_text():
    assert own.of_text(own.as_text(cable()), "fitted.yaml") == cable()


@pytest.mark.parametrize(
    ("torque", "words"),
    [
        ("-k*sin(angl)", "angl is not known; did you mean angle?; at character 8: -k*sin(>>>angl)"),
        ("0.1*angle", "its unit has a mass to the power of 0, expected 1"),
        ("-k^2*angle", "its unit has a mass to the power of 2, expected 1"),
        ("-k*angle + 0.1", "a sum of what has a mass in its unit and what has not; at character 12"),
        ("-sin(k)*angle", "sin of what has a mass in its unit"),
        ("-k*9^9^9^9", "this is no number; at character 6: -k*9^>>>9^9^9"),
        ("-k/(angle - angle)", "is no number for any motion"),
        ("-k*sqrt(-1 - angle^2)", "where k is 0 it adds nan"),
        ("-k*mean(mean(x*y, x), y)", "more than 1 times mean within each other"),
        ("-k*alpha2^2/100", "is not linear in the accelerations"),
        ("-k*angle + a1*g*sin(angle)", "where k is 0 it adds"),
        (["-k*angle"], "expected a formula"),
    ],
)
def test_a_wrong_formula_is_refused_with_its_place(torque, words):
    """What else is no formula is in test_syntax.py."""
    message = refusal(cable(torque=torque))
    assert words in message
    assert "cable" in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"joint": "middle"}, "unknown joint of mine.yaml: cable: 'middle'"),
        ({"joint": []}, "expected each joint once"),
        ({"torke": "k"}, "unknown key in mine.yaml: cable: 'torke'; did you mean 'torque'?"),
        ({"parameters": {}}, "0 parameters; expected at least one"),
        ({"parameters": {"k": STIFFNESS | {"unit": "furlong"}}}, "unit is 'furlong'; expected SI units"),
        ({"parameters": {"k": STIFFNESS | {"limits": [1, 0]}}}, "upper limit is 0; expected a number, at least 1"),
        ({"parameters": {"k": STIFFNESS | {"limits": [1, 2], "typical": 1.5}}}, "no parameter can be 0"),
        ({"parameters": {"k": STIFFNESS | {"typical": 0}}}, "typical is 0"),
        ({"parameters": {"k": STIFFNESS, "m": STIFFNESS}}, "the parameter m is in no formula"),
        ({"parameters": {"angle": STIFFNESS}}, "angle has a meaning already"),
        ({"parameters": {"K": STIFFNESS}}, "expected small letters, digits and _"),
        ({"where": {"a": "b", "b": "angle"}}, "where: a: b is not known"),
        ({"torque": "0*k", "friction": "k*abs(acceleration)"}, "free1 and free2, by the paper's model, are known"),
        ({"states": {s: {"rate": "speed"} for s in ("p", "q", "r")}}, "3 states; a law has at most 2"),
        ({"where": {"a": "rate(u)", "b": "rate(a)", "c": "rate(b)", "d": "rate(c)"}}, "more than 3 rates"),
        ({"description": ""}, "expected a few words"),
        ({"parameters": {"k": STIFFNESS | {"begins": [1]}}}, "begins is [1]; expected at most 20 values of a shape"),
        ({"parameters": {"k": STIFFNESS | {"shape": True, "begins": 1}}}, "begins is 1; expected at most 20 values"),
        ({"parameters": {"k": STIFFNESS | {"shape": True, "begins": ["a"]}}}, "begins is 'a'; expected a number"),
    ],
)
def test_a_wrong_definition_is_refused_with_what_is_wrong(changed, words):
    assert words in refusal(cable(**changed))


def test_names_of_the_catalogue_are_taken():
    assert "choose another one" in refusal({"joint_spring": cable()["cable"]})


def test_a_law_may_have_states_of_its_own_and_move_the_base():
    definitions = cable(torque="-k*stretch", states={"stretch": {"rate": "speed - stretch/0.1", "limit": 2.0}})
    definitions["soft_base"] = {
        "joint": "base", "cart": "-compliance*pull",
        "parameters": {"compliance": {"unit": "1/kg", "limits": [0, 1], "typical": 0.01}},
    }  # fmt: skip
    own.use(definitions, A22, "mine.yaml")
    cable_of_outer, base = known_effects()[-2:]
    assert cable_of_outer.brings_states
    assert base.parameters[0].inertia_power == -1


def refused(definitions):
    """Return why effects are refused; nothing where they are taken."""
    try:
        own.effects_of(definitions, A22, "mine.yaml")
    except OptionError as error:
        return str(error)
    return ""


@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(), lambda s: st.lists(s) | st.dictionaries(st.text(), s)
    )
)
def test_any_content_is_taken_or_refused_in_one_line(content):
    assert "\n" not in refused({"cable": content})


@given(st.text(alphabet="k angle01.+-*/^(),sincoexp_", max_size=40))
def test_any_text_is_a_formula_or_refused_in_one_line(torque):
    before = dict(os.environ)
    assert "\n" not in refused(cable(torque=torque))
    assert dict(os.environ) == before
