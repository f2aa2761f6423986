# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The command that says which swing to record next."""

import json
import shutil

import pytest

from cdp_ident.commands.suggest import main
from cdp_ident.report.folder import REPORT

FEW = ["--spacing", "90"]


def test_without_a_question_the_usual_ones_are_answered(report_folder, capsys):
    assert main([str(report_folder), *FEW]) == 0
    said = capsys.readouterr().out
    assert "all base parameters: let go with the inner rod" in said
    assert "coulomb friction, outer, torque: let go" in said
    assert "A22, and with it every torque in N m: clamp " in said
    assert "standard deviation now" in said


def test_a_weight_is_tried_beside_none(report_folder, capsys):
    told = ["--weight", "outer=0.05,0.30", "--weight-std", "1e-5,1e-4"]
    assert main([str(report_folder), *FEW, "--for", "A22", "--for", "all", *told]) == 0
    of_inertia, of_groups = capsys.readouterr().out.split("\n\n")[:2]
    assert "clamp 0.050000 ± 0.000010 kg at 0.30000 ± 0.00010 m on the outer rod" in of_inertia
    assert "these trials do not show it; it is determined then, to ± 0.0" in of_inertia
    assert of_groups.startswith("all base parameters: ")


def test_a_group_is_known_by_its_short_name_and_an_effect_by_its_own(report_folder, capsys):
    assert main([str(report_folder), *FEW, "--for", "c1", "--for", "coulomb_friction.outer", "--most-inner", "90"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("c1/A22: ")
    assert "coulomb_friction.outer.torque" in said


def test_two_effects_are_told_apart(report_folder, capsys):
    assert main([str(report_folder), *FEW, "--between", "load_friction.outer", "coulomb_friction.outer"]) == 0
    assert "standard deviations apart, now" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--for", "c3"], "unknown --for: 'c3'"),
        (["--for", "m2"], "no swing determines m2 by itself; ask for a base parameter or, with a weight, for A22"),
        (["--weight", "0.05,0.30"], "unknown rod of --weight: '0.05,0.30'"),
        (["--weight", "outer=0.05"], "--weight outer=0.05 is [0.05]; expected [mass in kg, place in m]"),
        (["--weight", "outer=heavy,0.3"], "expected [mass in kg, place in m]"),
        (["--weight", "outer=0.05,30"], "30 m is far beyond the rod of 0.4 m"),
        (["--weight", "inner=50,0.3"], "50 kg is far heavier than the pendulum"),
        (["--weight", "outer=0,0.3"], "a mass of 0 is no weight"),
        (["--weight", "outer=0.05,0.3", "--weight-std", "0,-1"], "--weight-std 0,-1 is -1.0; expected a number"),
        (["--weight-std", "1e-4,1e-3"], "--weight-std is given, but --weight is not"),
        (["--spacing", "1"], "1 is not a number from 5 to 90"),
        (["--spacing", "nan"], "nan is not a number from 5 to 90"),
        (["--most-outer", "400"], "400 is not a number from 0 to 180"),
        (["--most-outer", "10", "--most-inner", "10"], "give a smaller --spacing"),
        (["--between", "air_drag.outer", "joint_spring.inner"], "one of them must be in the fitted model"),
        (["--between", "air_drag.outer", "nothing.outer"], "unknown effect of --between"),
        (["--between", "coulomb_friction.outer", "coulomb_friction.outer"], "the fitted model has both"),
        (["--between", "coulomb_friction.outer", "stribeck_friction.outer"], "the second can be the first"),
    ],
)
def test_a_question_that_has_no_answer_is_refused_in_one_line(report_folder, refused, options, expected):
    assert expected in refused(main, [report_folder, *FEW, *options])


def test_a_fit_that_failed_has_no_advice(report_folder, tmp_path, refused):
    folder = shutil.copytree(report_folder, tmp_path / "report")
    content = json.loads((folder / REPORT).read_text())
    content["next_trial"] = None
    (folder / REPORT).write_text(json.dumps(content))
    assert "says nothing of a next trial" in refused(main, [folder])


def test_a_folder_without_a_report_is_refused(tmp_path, refused):
    assert "there is no" in refused(main, [tmp_path])
