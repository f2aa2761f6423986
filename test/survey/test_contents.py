# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a survey tells of reports whose numbers are known, and how its page shows them."""

import copy
import json

import numpy as np
import pytest

from cdp_ident.configuration.settings import Settings
from cdp_ident.output_folder import json_text
from cdp_ident.survey.contents import survey
from cdp_ident.survey.page import chapter, figures, survey_html, verdict
from cdp_ident.survey.run import LeftOut
from scenarios.fleet import finished

OILED = 4
FRICTION = "coulomb friction, outer: torque"
EVIL = "</script><img src=x onerror=alert(1)>"


def series(report, rig, rng, days, friction):
    """Return a rig's days: each group scatters by twice its deviation, and friction has a factor."""
    pieces = []
    for day in range(days):
        one = copy.deepcopy(report)
        for group in one["after"]["groups"].values():
            group["value"] += 2 * group["std"] * rng.standard_normal()
        torque = one["effects"][0]["parameters"]["torque"]["as_fitted"]
        torque["value"] = friction(day) * torque["value"] + 2 * torque["std"] * rng.standard_normal()
        pieces.append(finished(one, rig, day))
    return pieces


@pytest.fixture
def pieces(read_content):
    rng = np.random.default_rng(1)
    return [
        *series(read_content, "rig1", rng, 8, lambda day: 1.0),
        *series(read_content, "rig2", rng, 8, lambda day: 1.0 if day < OILED else 0.5),
        *series(read_content, "rig3", rng, 6, lambda day: 1.0),
    ]


def surveyed(pieces, **more):
    return survey(pieces, "day", Settings.of({}), **more)


def test_the_change_and_the_rig_that_differs_are_told_and_nothing_else(pieces):
    found = surveyed(pieces)
    (change,) = found["changes"]
    assert (change["rig"], change["quantity"], change["until"], change["since"]) == ("rig2", FRICTION, "day 3", "day 4")
    assert change["after"]["value"] == pytest.approx(0.5 * change["before"]["value"], rel=0.1)
    (difference,) = found["differences"]
    assert (difference["rig"], difference["others"], difference["quantity"]) == ("rig2", ["rig1", "rig3"], FRICTION)
    assert verdict(found).startswith("3 rigs, 22 pieces; rig2 changed in coulomb friction, outer: torque between day 3")


def test_each_rig_s_quantities_stand_over_time_with_their_intervals(pieces):
    rig = surveyed(pieces)["rigs"][2]
    quantities = {quantity["name"]: quantity for quantity in rig["quantities"]}
    assert [estimate["piece"] for estimate in quantities[FRICTION]["estimates"]] == [f"day {k}" for k in range(6)]
    group = pieces[-1].report["after"]["groups"]["c2_over_A22"]
    last = quantities["c2/A22 = c2 / A22"]["estimates"][-1]
    assert (last["value"], last["std"]) == (group["value"], group["std"])


def test_an_effect_that_is_found_from_a_day_on_is_told(read_content):
    without = copy.deepcopy(read_content)
    without["effects"] = []
    pieces = [finished(without if day < 12 else read_content, "rig1", day) for day in range(24)]
    (change,) = [change for change in surveyed(pieces)["changes"] if change["what"] == "found"]
    assert (change["since"], change["before"], change["after"]) == (
        "day 12",
        {"found": 0, "of": 12},
        {"found": 12, "of": 12},
    )
    (changed, *_) = chapter(surveyed(pieces)).shown
    assert any("found in 0 of 12" in row for row in changed.rows)


def test_pieces_without_a_result_are_told_and_take_nothing_from_the_others(pieces, read_content):
    failed = [finished(None, "rig4", 0, "no bag of it holds a trial"), finished(read_content, "rig4", 1, "fit failed")]
    found = surveyed([*pieces, *failed], left_out=[LeftOut("/trials/copy", "it is the same bag as another")])
    assert len(found["changes"]) == 1
    assert found["rigs"][3]["quantities"] == []
    assert [row[2] for row in chapter(found).shown[-1].rows] == [
        "no bag of it holds a trial",
        "fit failed",
        "it is the same bag as another",
    ]
    assert "24 pieces, 2 of them without a result" in verdict(found)
    assert "rig4" in survey_html(found)


def test_one_piece_alone_is_a_survey_too(read_content):
    found = surveyed([finished(read_content, "rig1", 0)])
    assert (found["changes"], found["differences"]) == ([], [])
    assert "nothing changed" in verdict(found)
    assert survey_html(found)


def test_the_page_has_a_figure_of_each_quantity_and_leads_to_each_piece(pieces):
    found = surveyed(pieces)
    drawn = figures(found)
    assert [figure.title for figure in drawn][:5] == [q["name"] for q in found["rigs"][0]["quantities"]][:5]
    assert FRICTION in [figure.title for figure in drawn]
    page = survey_html(found)
    assert page.count("/report.html") == 22
    # Two stretches of the rig that changed, one of each other.
    (friction,) = [figure for figure in drawn if figure.title == FRICTION]
    assert len([mark for mark in friction.panels[0].marks if mark.dash == "dash"]) == 4


def test_text_from_bags_stays_text(read_content):
    assert EVIL not in survey_html(surveyed([finished(read_content, EVIL, 0)]))


def test_it_is_strict_json(pieces):
    found = surveyed(pieces)
    assert json.loads(json_text(found))["schema"] == "cdp_ident/survey/1"
