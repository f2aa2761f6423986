# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an answer to a hidden truth is worth."""

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks._product import Found, Named, catalogue_without
from benchmarks._scores import Score, conclusion, score, strange, summary
from cdp_ident.tracing import neighbours, odds
from reference.effects import Effect
from reference.settings import draw_setting
from reference.truths import Hidden, Truth

SETTING = draw_setting(np.random.default_rng(0))
FLOOR = 1e-3


def hidden(name, joint, visible=5.0):
    return Hidden(Effect(name, joint, "N m", 1e-5, 1.0), 0.01, visible)


def named(name, joint, *also):
    return Named(f"{name}.{joint}", (name, joint), also)


def judged(kind, there, names, before=5.0, after=1.0, remains=False):
    truth = Truth(kind, 0, "equations", (), SETTING, tuple(there), FLOOR)
    return score(truth, Found(tuple(names), before * FLOOR, after * FLOOR, remains, "said"), 2.0)


DRY = hidden("coulomb_friction", "outer")


@pytest.mark.parametrize(
    ("result", "verdict"),
    [
        (judged("none", [], []), "ok"),
        (judged("none", [], [named("air_drag", "inner")]), "FALSE"),
        (judged("coulomb_friction.outer", [DRY], [named("coulomb_friction", "outer")]), "ok"),
        (judged("coulomb_friction.outer", [DRY], [named("coulomb_friction", "outer")], after=1.2), "left"),
        (judged("coulomb_friction.outer", [DRY], [named("coulomb_friction", "inner")]), "FALSE"),
        (
            judged(
                "coulomb_friction.outer", [DRY], [named("air_drag", "outer", ("coulomb_friction", "outer"))]
            ),
            "ok",
        ),
        (judged("coulomb_friction.outer", [DRY], []), "MISSED"),
        (judged("coulomb_friction.outer", [DRY], [], before=1.05), "weak"),
        (judged("partial_rub.inner", [hidden("partial_rub", "inner")], [], after=5.0), "UNSEEN"),
        (judged("partial_rub.inner", [hidden("partial_rub", "inner")], [], after=5.0, remains=True), "left"),
        (judged("partial_rub.inner", [hidden("partial_rub", "inner")], [named("unknown_torque", "inner")]), "ok"),
        (judged("partial_rub.inner", [hidden("partial_rub", "inner")], [named("cogging_torque", "inner")]), "FALSE"),
        (judged("gravity_tilt.base", [hidden("gravity_tilt", "base")], [named("encoder_offset", "inner")]), "ok"),
        (strange(judged("coulomb_friction.outer", [DRY], [named("coulomb_friction", "outer")])), "FALSE"),
        (strange(judged("coulomb_friction.outer", [DRY], [])), "ok"),
        (strange(judged("coulomb_friction.outer", [DRY], [], after=2.0)), "UNSEEN"),
        (Score("none", 0, "mujoco", error="Traceback\nLinAlgError: Singular matrix"), "CRASHED"),
    ],
)  # fmt: skip
def test_a_result_has_the_worst_of_its_verdicts(result, verdict):
    assert result.verdict == verdict
    assert result.line.startswith(verdict)
    assert json.loads(json.dumps(result.as_json))["verdict"] == verdict


def test_what_is_as_possible_as_a_name_is_told_beside_it_and_one_name_does_not_do_for_two_effects():
    found = judged("coulomb_friction.outer", [DRY], [named("air_drag", "outer", ("coulomb_friction", "outer"))])
    assert "-> air_drag.outer or coulomb_friction outer; " in found.line
    twice = [named("coulomb_friction", "outer")] * 2
    assert judged("coulomb_friction.outer", [DRY], twice).false == ("coulomb_friction.outer",)


def test_of_several_effects_those_that_matter_less_may_be_missed():
    both = judged("a.outer+b.outer", [replace(DRY, visible=0.3), hidden("air_drag", "outer")], [])
    assert (both.weak, both.missed) == (("coulomb_friction.outer",), ("air_drag.outer",))
    wave, ripple = hidden("cogging_torque", "outer"), hidden("cogging_torque", "outer", visible=0.3)
    one = judged("cogging_torque.outer+cogging_torque.outer", [ripple, wave], [named("cogging_torque", "outer")])
    assert one.verdict == "weak"


def test_effects_are_out_of_the_catalogue_for_a_while():
    everywhere = [neighbours, odds]
    with catalogue_without({"coulomb_friction"}):
        assert all("coulomb_friction" not in {e.name for e in of.known_effects()} for of in everywhere)
        assert all("air_drag" in {e.name for e in of.known_effects()} for of in everywhere)
    assert all("coulomb_friction" in {e.name for e in of.known_effects()} for of in everywhere)


def test_the_table_counts_by_group_and_engine():
    scores = [judged("none", [], []), Score("none", 1, "mujoco", error="died"), judged("x.outer", [DRY], [])]
    assert summary(scores).row_count == 4
    assert "no result: 1" in conclusion(scores)
    assert "1 with nothing missed or false" in conclusion(scores)
