# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters with their intervals, in words and pictures."""

import numpy as np
import pytest

from cdp_ident.model.parameters import GROUPS, groups_of
from cdp_ident.report.figures.description import Heat, Line
from cdp_ident.report.parameters import (
    against_nominal,
    correlation,
    determined_words,
    estimates_against,
    how_determined,
    nominal_values,
    repeatability,
)


def intervals(panel):
    return [mark for mark in panel.marks if isinstance(mark, Line) and mark.half_widths]


def test_groups_and_physical_values_stand_over_nominal(read_content):
    groups, physical = against_nominal(read_content).panels
    before, after = intervals(groups)
    assert len(after.x) == 5
    assert after.x[2] == pytest.approx(read_content["after"]["groups"]["a1_over_A22"]["value"] / 2.6327, rel=1e-3)
    assert not any(after.hollow)
    assert list(intervals(physical)[1].hollow) == [True] * 9 + [False, True]  # L alone is determined
    assert [name for _, name in physical.y.ticks] == ["m1", "m2", "m0", "l1", "l2", "J1", "J2", "c1", "c2", "L", "A22"]
    m1 = read_content["after"]["physical"]["m1"]
    assert intervals(physical)[1].half_widths[0] == pytest.approx(1.96 * m1["std"] / 0.108)
    assert before.colour != after.colour
    assert before.shape != after.shape


def test_a_value_that_the_trials_do_not_show_at_all_has_no_end(read_content):
    read_content["after"]["groups"]["c2_over_A22"].update(std=np.inf, determined=False)
    after = intervals(against_nominal(read_content).panels[0])[1]
    assert after.half_widths[4] == np.inf
    assert after.hollow[4]


def test_a_nominal_value_of_zero_is_left_out(read_content):
    read_content["run"]["options"] |= {"nominal.m0": 0.0, "nominal.c1": 0.0}
    figure = against_nominal(read_content)
    assert not {"m0", "c1"} & {name for _, name in figure.panels[1].y.ticks}
    assert "c2/A22" in figure.alternative
    assert "c1/A22" not in figure.alternative


def test_correlations_are_of_the_final_model(read_content):
    figure = correlation(read_content)
    (heat,) = figure.panels[0].marks
    assert isinstance(heat, Heat)
    assert figure.panels[0].y.ticks[-1] == (6.0, "coulomb friction,\nouter, torque  7")
    assert figure.panels[0].x.ticks[-1] == (6.0, "7")
    assert np.diag(heat.matrix) == pytest.approx(1.0)
    assert heat.matrix == pytest.approx(heat.matrix.T)


def test_each_trial_stands_against_the_joint_fit(read_content):
    (figure,) = repeatability(read_content)
    wide, folded = intervals(figure.panels[0])
    alone = read_content["repeatability"]["trials"][0]["groups"]["c2_over_A22"]["value"]
    joint = read_content["after"]["groups"]["c2_over_A22"]["value"]
    assert wide.label == "swing_wide"
    assert wide.x[4] == pytest.approx(100 * (alone / joint - 1))
    assert (wide.colour, wide.shape) != (folded.colour, folded.shape)


def test_many_runs_find_room(read_content):
    estimates = [(f"run {k}", read_content["repeatability"]["trials"][0]["groups"]) for k in range(12)]
    joint = {"a1_over_A22": {"value": 2.7}, "c2_over_A22": {"value": 0.01}}
    many = estimates_against(joint, "", estimates, "", ("", "", ""))
    positions = sorted(position for mark in intervals(many.panels[0]) for position in mark.y)
    assert np.min(np.diff(positions)) * many.panels[0].height / 2 > 8  # pixels


def test_a_measured_value_stands_in_for_the_nominal_one(read_content):
    assert nominal_values(read_content)["m0"] == 0.208
    read_content["run"]["options"]["known.m0"] = 0.3
    nominal = nominal_values(read_content)
    assert nominal["m0"] == 0.3
    assert how_determined(read_content, "m0") == "measured"
    table_2 = np.array([0.108, 0.108, 0.3, 0.2, 0.2, 0.00133, 0.00133, 0.00705, 0.00305])
    assert [nominal[group.symbol] for group in GROUPS] == pytest.approx(groups_of(table_2, 0.4))


def test_an_effect_in_doubt_is_mentioned_with_what_it_would_change(read_content):
    group = read_content["after"]["groups"]["c2_over_A22"]
    group.update(value=0.003, std=0.0004)
    changes = dict.fromkeys(read_content["after"]["groups"], 0.0)
    read_content["in_doubt"] = [
        {"effect": "coulomb_friction.outer", "weight": 0.5, "changes": {**changes, "c2_over_A22": -0.001}},
        {"effect": "gravity_tilt.base", "weight": 0.1, "changes": {**changes, "c2_over_A22": -0.0001}},
    ]
    added = determined_words(read_content)[len(read_content["identifiability"]["words"]) :]
    assert added == [
        "coulomb friction, outer, is neither shown nor excluded; it would change c2 / A22 by -33 %, and intervals "
        "allow for that"
    ]


def test_it_is_said_how_a_value_was_come_by(read_content):
    assert how_determined(read_content, "g") == "given"
    assert how_determined(read_content, "L") == "yes"
    assert how_determined(read_content, "m1") == "no: nearest to nominal"
    read_content["after"]["physical"]["m1"]["determined"] = True
    assert how_determined(read_content, "m1") == "yes"
