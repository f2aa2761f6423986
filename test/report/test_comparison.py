# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Several reports side by side."""

import copy
import math

import pytest

from cdp_ident.errors import OptionError, ReportError
from cdp_ident.output_folder import json_text
from cdp_ident.report.comparison import compare, fitted_quantity, read_runs
from cdp_ident.report.folder import REPORT


def table(runs, title):
    return {row[0]: row[1:] for row in next(c for c in compare(runs) if c.title.startswith(title)).rows}


@pytest.fixture
def runs(read_content):
    return {"worn": read_content, "oiled": copy.deepcopy(read_content)}


def test_a_change_is_told_in_units_of_its_deviation(runs):
    assert table(runs, "Base parameters")["c2/A22 = c2 / A22"][2] == "+0.0"
    assert table(runs, "Effects")["coulomb friction, outer: torque"][2] == "+0.0"
    group = runs["oiled"]["after"]["groups"]["c2_over_A22"]
    group["value"] -= 5 * 2**0.5 * group["std"]
    assert table(runs, "Base parameters")["c2/A22 = c2 / A22"][2] == "-5.0 (changed)"


def test_torques_differ_as_the_motion_shows_them_not_as_the_masses_are_known(runs):
    torque = runs["oiled"]["effects"][0]["parameters"]["torque"]
    torque["value"] *= 0.9
    torque["as_fitted"]["value"] *= 0.9
    worn, oiled, difference = table(runs, "Effects")["coulomb friction, outer: torque"]
    assert worn != oiled
    assert float(difference.split()[0]) < -50
    assert abs(0.1 * torque["value"]) < torque["std"]  # in N m nobody could tell


def test_an_effect_that_only_one_has_stands_alone(runs):
    runs["oiled"]["effects"] = []
    worn, oiled, difference = table(runs, "Effects")["coulomb friction, outer: torque"]
    assert worn.endswith(" N m)")
    assert (oiled, difference) == ("–", "–")


def test_a_group_is_compared_even_where_it_is_hardly_seen(runs):
    group = runs["oiled"]["after"]["groups"]["c1_over_A22"]
    group.update(value=0.0, std=0.02, determined=False)
    assert table(runs, "Base parameters")["c1/A22 = c1 / A22"][2].endswith("(changed)")
    group["std"] = math.inf
    assert table(runs, "Base parameters")["c1/A22 = c1 / A22"][2] == "–"


def test_three_runs_are_compared_with_the_first(runs):
    runs["third"] = runs["worn"]
    groups = next(c for c in compare(runs) if c.title.startswith("Base parameters"))
    assert groups.columns[4:] == ("oiled − worn, in std", "third − worn, in std")
    assert all(len(row) == len(groups.columns) for row in groups.rows)


def test_runs_are_called_by_what_differs_in_their_paths(content, tmp_path):
    for name in ("a/report", "b/report"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / REPORT).write_text(json_text(content))
    both = read_runs([tmp_path / "a/report", tmp_path / "b/report"])
    assert list(both) == ["a/report", "b/report"]
    with pytest.raises(OptionError, match="is given twice"):
        read_runs([tmp_path / "a/report", tmp_path / "b/../a/report"])
    with pytest.raises(ReportError, match="there is no"):
        read_runs([tmp_path / "a/report", tmp_path])


def test_groups_and_what_trials_determine_can_be_compared(read_content):
    assert fitted_quantity(read_content, "groups", "c1_over_A22").is_known
    assert not fitted_quantity(read_content, "physical", "m0").is_known
    read_content["after"]["physical"]["m0"]["determined"] = True
    assert fitted_quantity(read_content, "physical", "m0").is_known
    # What was measured beforehand says nothing of the trials.
    read_content["run"]["options"]["known.m0"] = 0.208
    assert not fitted_quantity(read_content, "physical", "m0").is_known
