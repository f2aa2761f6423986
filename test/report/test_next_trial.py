"""What a report says of a next trial, and what is made of it again."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.report.knowledge import knowledge_of
from cdp_ident.report.next_trial import Question, next_trial_section, strength_of, usual_questions
from cdp_ident.report.wording import advice_words


def test_the_report_answers_for_all_groups_and_for_the_strength_of_each_effect(content):
    advice = content["next_trial"]["advice"]
    assert [(a["for"], a["against"]) for a in advice] == [("all", None), ("coulomb_friction.outer.torque", None)]
    for one in advice:
        assert 0 < one["expected"] <= one["worst"] < 1
        values = np.array(one["map"]["values"], dtype=float)
        assert values.shape == (8, 8)
        assert np.all(values[np.isfinite(values)] <= 1 + 1e-9)  # no trial makes anything less sure
        assert np.all(np.array(one["std_then"]) < one["std_now"])
    groups = content["after"]["groups"]
    assert advice[0]["std_now"] == pytest.approx([quantity["std"] for quantity in groups.values()], rel=1e-6)


def test_the_advice_is_in_words(content):
    of_all, of_friction = advice_words(content)
    assert of_all.startswith("all base parameters: let go with the inner rod ")
    assert "their intervals fall to " in of_all
    assert of_friction.startswith("coulomb friction, outer, torque: ")
    changed = copy.deepcopy(content)
    first = changed["next_trial"]["advice"][0]
    first |= {"for": "coulomb_friction.outer", "against": "air_drag outer", "expected": 9.04, "deviations_now": 1.2}
    first |= {"inner_rad": 0.0, "outer_rad": np.pi}
    assert advice_words(changed)[0] == (
        "coulomb friction, outer, or air drag, outer: let go with the inner rod hanging and the outer rod upright: "
        "the two are then 9 standard deviations apart, now 1.2"
    )
    changed["next_trial"] = None
    assert advice_words(changed) == []


def test_what_could_be_another_effect_is_asked_first(read_content):
    model = knowledge_of(read_content).model
    asked = usual_questions(model, {"coulomb_friction.outer": ["air_drag outer"]})
    assert asked[0] == Question("coulomb_friction.outer", "air_drag outer")
    assert strength_of(model, "coulomb_friction.outer") == "coulomb_friction.outer.torque"


def test_what_cannot_be_computed_is_told_and_costs_the_advice_alone(outcome):
    trace = outcome.trace
    fit = replace(trace.after.fit, values=np.full_like(trace.after.fit.values, np.nan))
    lost = replace(trace, after=replace(trace.after, fit=fit))
    told = []
    assert next_trial_section(replace(outcome, trace=lost), told.append) is None
    assert told[0].startswith("which trial to record next: ")
