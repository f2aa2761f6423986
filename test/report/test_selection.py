# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which effects were found and what else was tried, in words and pictures."""

import numpy as np
import pytest

from cdp_ident.report.figures.description import Bars
from cdp_ident.report.selection import candidates, effects_words, selection, share_words
from cdp_ident.report.wording import chance, key_words, odds


@pytest.mark.parametrize(
    ("action", "words"),
    [
        ("dropped cogging_torque.inner.13 per turn", "dropped cogging torque, inner, 13 per turn"),
        (
            "exchanged air_drag.outer.rotation for air_drag.outer.strips",
            "exchanged air drag, outer, rotation for air drag, outer, strips",
        ),
        ("added gravity_tilt.base and encoder_offset.outer", "added gravity tilt, base and encoder offset, outer"),
        ("added inner zeros of each trial", "added inner zeros of each trial"),
    ],
)
def test_a_step_of_the_selection_is_in_words(action, words):
    assert key_words(action) == words


@pytest.mark.parametrize(("looked_in", "said"), [(0.0, False), (1.0, True), (23.9, False)])
def test_it_is_said_where_effects_were_looked_for_in_a_part_only(read_content, looked_in, said):
    read_content["selection"]["looked_in_s"] = looked_in
    assert bool(share_words(read_content)) == said


def test_effects_that_were_tried_together_are_named_together():
    assert effects_words(["air_drag.outer", "joint_spring.outer"]) == "air drag, outer and joint spring, outer"
    assert effects_words([]) == "the same, from elsewhere"


@pytest.fixture
def with_many_tried(read_content):
    """The report, as if more had been tried at the first step, and that had been the only one."""
    keys = ("air_drag.outer.strips", "load_friction.outer", "quadratic_friction.outer", "encoder_offset.outer")
    others = [{"effects": [key], "log10_odds": -float(k)} for k, key in enumerate(keys)]
    tried = [others[0], {"effects": ["coulomb_friction.outer"], "log10_odds": 400.0}, *others[1:]]
    read_content["selection"]["steps"] = [
        {"action": "added coulomb_friction.outer", "log10_odds": 400.0, "tried": tried}
    ]
    return read_content


def test_every_effect_that_was_tried_is_in_the_picture_and_the_taken_one_stands_out(with_many_tried):
    (figure,) = selection(with_many_tried)
    panel = figure.panels[0]
    tried = with_many_tried["selection"]["steps"][0]["tried"]
    assert [name.replace("\n", " ") for _, name in panel.y.ticks][:1] == ["air drag, outer, strips"]
    bars = {mark.label: mark for mark in panel.marks if isinstance(mark, Bars)}
    assert list(bars["taken"].x) == [400.0]
    assert len(bars["tried, not taken"].x) == len(tried) - 1
    place = [position for position, _ in panel.y.ticks].index(bars["taken"].y[0])
    assert tried[place]["effects"] == ["coulomb_friction.outer"]
    assert panel.title == "Step 1: added coulomb friction, outer"
    assert panel.marks[-1].x.tolist() == [0.0, 0.0]


def test_where_nothing_helps_nothing_stands_out(with_many_tried):
    step = with_many_tried["selection"]["steps"][0]
    step["tried"] = [one for one in step["tried"] if one["log10_odds"] < 0]
    (figure,) = selection(with_many_tried)
    assert [mark.label for mark in figure.panels[0].marks] == ["tried, not taken", "as probable as before"]


def test_a_name_of_many_lines_has_room_of_its_own(with_many_tried):
    tried = with_many_tried["selection"]["steps"][0]["tried"]
    tried[1]["effects"] = ["encoder_eccentricity.outer", "encoder_eccentricity.inner", "gravity_tilt.base"]
    (figure,) = selection(with_many_tried)
    positions = [position for position, _ in figure.panels[0].y.ticks]
    lines = figure.panels[0].y.ticks[1][1].count("\n") + 1
    assert lines > 2
    assert positions[2] - positions[1] > positions[4] - positions[3]
    assert figure.panels[0].height / (positions[-1] - positions[0] + 1) * (positions[2] - positions[0]) > 13 * (
        lines + 1
    )


def test_what_could_not_be_fitted_has_no_bar(with_many_tried):
    tried = with_many_tried["selection"]["steps"][0]["tried"]
    tried[-1]["log10_odds"], tried[-2]["log10_odds"] = np.inf, np.nan
    (figure,) = selection(with_many_tried)
    assert len(figure.panels[0].y.ticks) == len(tried) - 2
    for one in tried:
        one["log10_odds"] = np.inf
    assert list(selection(with_many_tried)) == []


def test_every_effect_that_was_looked_for_has_a_bar_with_its_odds_and_probability(read_content):
    (figure,) = candidates(read_content)
    (panel,) = figure.panels
    looked_for = {tuple(one["effect"].split(".")[:2]) for one in read_content["selection"]["candidates"]}
    assert len(panel.y.ticks) == len(looked_for)
    best = read_content["selection"]["candidates"][0]
    assert panel.marks[0].x[0] == best["log10_odds"]
    assert panel.marks[0].words[0] == f"{odds(best['log10_odds'])}, {chance(best['probability'])}"
