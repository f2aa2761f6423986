# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a report says of a next trial, in numbers, words and maps, and what is made of it again."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.questions import Question, answers, strength_of, usual_questions
from cdp_ident.design.starts import Grid
from cdp_ident.report.knowledge import knowledge_of
from cdp_ident.report.next_trial import advice_map, advice_words, next_trial_section
from scenarios.weighted import WEIGHT


def test_the_report_answers_for_all_groups_and_for_the_strength_of_each_effect(content):
    advice = content["next_trial"]["advice"]
    *shown, inertia = advice
    asked = [(a["for"], a["against"], a["weights"]) for a in shown]
    assert asked == [("all", None, []), ("coulomb_friction.outer.torque", None, [])]
    assert inertia["for"] == "A22"
    for one in shown:
        assert one["expected_unloaded"] == np.inf
        assert 0 < one["expected"] <= one["worst"] < 1
        values = np.array(one["map"]["values"], dtype=float)
        assert values.shape == (8, 8)
        assert np.all(values[np.isfinite(values)] <= 1 + 1e-9)  # no trial makes anything less sure
        assert np.all(np.array(one["std_then"]) < one["std_now"])
    groups = content["after"]["groups"]
    assert advice[0]["std_now"] == pytest.approx([quantity["std"] for quantity in groups.values()], rel=1e-6)


def test_where_no_trial_had_a_weight_the_report_says_which_one_would_determine_the_inertia_and_how_well(content):
    inertia = content["next_trial"]["advice"][-1]
    (weight,) = inertia["weights"]
    value = content["after"]["physical"]["A22"]["value"]
    assert weight["mass"] * content["after"]["physical"]["L"]["value"] ** 2 == pytest.approx(0.1 * value, rel=0.05)
    assert (inertia["names"], inertia["std_now"]) == (["A22"], [np.inf])
    assert inertia["std_then"] == pytest.approx([inertia["expected"] * value], rel=0.1)
    # A weight that is known to 1 % shows nothing better than to 1 %; the trial's noise adds little.
    assert inertia["expected"] == pytest.approx(0.01, rel=0.2)
    words = advice_words(content)[-1]
    assert words.startswith(f"A22, and with it every torque in N m: clamp {weight['mass']:.5f} ± ")
    assert "these trials do not show it; it is determined then, to ± 2" in words


def test_with_a_weight_that_the_trials_had_starts_are_tried_with_and_without_it(read_content):
    knowledge = knowledge_of(read_content)
    both = answers(knowledge, None, [Question("all"), Question("A22")], Grid.of(90.0), [(), (WEIGHT,), (WEIGHT,)])
    of_groups, of_inertia = both
    assert (of_groups.expected_unloaded < np.inf) == bool(of_groups.trial.weights)
    assert of_inertia.trial.weights == (WEIGHT,)
    assert of_inertia.expected < 1e-3
    assert of_inertia.expected_unloaded == np.inf


def test_what_a_weight_brings_is_said_beside_what_comes_without(read_content):
    first = read_content["next_trial"]["advice"][0]
    first |= {"weights": [vars(WEIGHT)], "inner_rad": 0.0, "outer_rad": 1.0, "expected": 0.4, "worst": 0.5}
    first["expected_unloaded"] = 0.6
    assert advice_words(read_content)[0] == (
        "all base parameters: clamp 0.050000 ± 0.000010 kg at 0.30000 ± 0.00010 m on the outer rod, and let go with "
        "the inner rod hanging and the outer rod at +57°: their intervals fall to 40 % of what they are (50 % at "
        "worst, where the hand misses by 5°); without a weight to 60 %"
    )


def test_where_no_trial_brings_anything_no_start_is_advised(read_content):
    first, second = read_content["next_trial"]["advice"][:2]
    first["expected"], second["expected"], second["worst"] = 0.97, 0.5, 0.9999
    words = advice_words(read_content)
    assert words[0] == "all base parameters: no trial makes them surer by as much as 5 %"
    assert "to 50 % of what it is (100 % at worst" in words[1]


def test_the_advice_is_in_words(content):
    of_all, of_friction, _ = advice_words(content)
    assert of_all.startswith("all base parameters: let go with the inner rod ")
    assert "their intervals fall to " in of_all
    assert of_friction.startswith("coulomb friction, outer, torque: ")
    changed = copy.deepcopy(content)
    first = changed["next_trial"]["advice"][0]
    first |= {"for": "coulomb_friction.outer", "against": "air_drag.outer", "expected": 9.04, "deviations_now": 1.2}
    first |= {"inner_rad": 0.0, "outer_rad": np.pi}
    assert advice_words(changed)[0] == (
        "coulomb friction, outer, or air drag, outer: let go with the inner rod hanging and the outer rod upright: "
        "the two are then 9 standard deviations apart, now 1.2"
    )
    changed["next_trial"] = None
    assert advice_words(changed) == []


def test_what_could_be_another_effect_is_asked_first(read_content):
    model = knowledge_of(read_content).model
    asked = usual_questions(model, [["air_drag.outer"]])
    assert asked[0] == Question("coulomb_friction.outer", "air_drag.outer")
    assert strength_of(model, "coulomb_friction.outer") == "coulomb_friction.outer.torque"


def test_what_cannot_be_computed_is_told_and_costs_the_advice_alone(outcome):
    trace = outcome.trace
    fit = trace.completed.fit
    fit = replace(fit, values=np.where(np.arange(len(fit.values)) < 5, np.nan, fit.values))
    lost = replace(trace, completed=replace(trace.completed, fit=fit))
    told = []
    assert next_trial_section(replace(outcome, trace=lost), told.append) is None
    assert told[0].startswith("which trial to record next: ")


def test_what_is_asked_to_end_has_no_advice_and_says_so(outcome):
    told, asked = [], iter([False] * 40)
    assert next_trial_section(outcome, told.append, lambda: next(asked, True)) is None
    assert told == ["which trial to record next: it was not looked for to the end"]


def test_the_map_has_each_start_and_at_the_one_to_take_a_dot_and_what_the_words_say(read_content):
    (figure,) = advice_map(read_content)
    advice = read_content["next_trial"]["advice"][0]
    heat, dot = figure.panels[0].marks
    inner, outer = (int(place[0]) for place in (dot.x, dot.y))
    assert np.degrees(advice["inner_rad"]) == pytest.approx(np.degrees(advice["map"]["inner_rad"][inner]))
    assert heat.matrix[outer, inner] == 100.0 * advice["expected"]
    assert f"fall to {heat.matrix[outer, inner]:.2g} %" in advice_words(read_content)[0]
    others = np.delete(heat.matrix.ravel(), outer * heat.matrix.shape[1] + inner)
    exact = 100.0 * np.array(advice["map"]["values"])
    assert np.isin(others, exact).all()
    assert figure.panels[0].title == "all base parameters [%]"


def test_starts_without_a_motion_are_left_blank(read_content):
    read_content["next_trial"]["advice"][0]["map"]["values"][0] = [np.inf] * 8
    (figure,) = advice_map(read_content)
    assert not np.isfinite(figure.panels[0].marks[0].matrix[:, 0]).any()


def test_two_effects_have_a_scale_of_their_own(read_content):
    advice = read_content["next_trial"]["advice"][0]
    advice["against"] = "air_drag.outer"
    advice["map"]["values"] = [[7.0] * 12 for _ in range(12)]
    (figure,) = advice_map(read_content)
    assert figure.panels[0].marks[0].limits == (-7.0, 7.0)


def test_what_no_trial_shows_yet_is_drawn_by_its_interval_then_and_starts_that_show_nothing_are_left_blank(
    read_content,
):
    (figure,) = advice_map(read_content)
    advice, panel = read_content["next_trial"]["advice"][-1], figure.panels[-1]
    assert panel.title == "A22, with a weight [± %]"
    heat = panel.marks[0]
    shown = heat.matrix[np.isfinite(heat.matrix)]
    assert 1.96 <= shown.min() <= shown.max() == heat.limits[1] / 2
    assert shown.max() < 100
    hanging = advice["map"]["values"][advice["map"]["inner_rad"].index(0.0)][advice["map"]["outer_rad"].index(0.0)]
    assert hanging == np.inf
