# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Formulas are typeset as they were written: what belongs together stays so, and text that is none stays text."""

import html
import re
import xml.etree.ElementTree as ET

import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.formulas.typesetting import Formula


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("torque = -k*(angle - 2)", r"$\mathrm{torque}=-k\,\left(\varphi -2\right)$"),
        ("torque = (a + b)*c/d^2", r"$\mathrm{torque}=\frac{\left(a+b\right)\,c}{{d}^{2}}$"),
        ("torque = a - (b - c)", r"$\mathrm{torque}=a-\left(b-c\right)$"),
        ("x' = omega1/m2_l2", r"$x'=\frac{\omega _{1}}{m_{2}\,l_{2}}$"),
        ("reading = exp(-x)*sqrt(abs(y))", r"$\mathrm{reading}={e}^{-x}\,\sqrt{\lvert y \rvert}$"),
        ("friction = 2e-9*sin(theta1 - theta2)", r"$\mathrm{friction}=2\,{10}^{-9}"
         r"\,\operatorname{sin}\left(\theta _{1}-\theta _{2}\right)$"),
        ("torque = dry_part*direction; x' = y", r"$\mathrm{torque}=\mathrm{dry\ part}\,"
         r"\operatorname{sgn}\left(\dot{\varphi }\right)$; $x'=y$"),
    ],
)  # fmt: skip
def test_brackets_are_those_that_are_needed_and_symbols_the_field_s(text, latex):
    assert Formula(text).latex == latex


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.key)
def test_every_law_of_the_catalogue_is_mathematics_on_a_page(effect):
    shown = Formula(effect.formula).__html__()
    if effect.curve is not None:
        assert shown == html.escape(effect.formula)
        return
    lines = re.findall(r"<math.*?</math>", shown)
    assert len(lines) == len(effect.formula.split("; "))
    for line in lines:
        tree = ET.fromstring(line)
        numbers = [element.text for element in tree.iter() if element.tag == "mn"]
        assert all(re.fullmatch(r"-?\d+(\.\d+)?", number or "") for number in numbers)


@pytest.mark.parametrize("text", ["a cubic B-spline over the joint's speed", "<b>x</b> = 1", "torque = <script>", ""])
def test_what_is_no_formula_is_plain_text_on_a_page(text):
    shown = Formula(text).__html__()
    assert not set(re.findall(r"</?(\w+)", shown)) & {"b", "script"}
    assert Formula(text) == text
