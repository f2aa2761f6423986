# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Identifications side by side, on the terminal and as a page."""

import re

import pytest

from cdp_ident.commands.compare import main
from cdp_ident.output_folder import json_text
from cdp_ident.report.folder import REPORT


@pytest.fixture
def folders(read_content, tmp_path):
    """Before and after a bearing was oiled, made up."""
    folders = [tmp_path / name for name in ("worn", "oiled")]
    for folder in folders:
        folder.mkdir()
        (folder / REPORT).write_text(json_text(read_content))
        torque = read_content["effects"][0]["parameters"]["torque"]
        torque["value"] /= 2
        torque["as_fitted"]["value"] /= 2
    return [str(folder) for folder in folders]


def test_the_difference_is_told_on_the_terminal(folders, capsys):
    assert main(folders) == 0
    out = capsys.readouterr().out
    assert re.search(r"coulomb friction, outer: torque +0.0336\S* .* 0.0168\S* .*-\S+ \(changed\)", out)
    assert "oiled − worn, in std" in out
    assert "Dry friction in the outer joint" in out


def test_page_and_text_go_where_they_are_asked_for(folders, tmp_path, capsys):
    out = tmp_path / "out"
    assert main([*folders, "--out", str(out)]) == 0
    assert {path.name for path in out.iterdir()} == {"compare.html", "compare.md", "figures"}
    text = (out / "compare.md").read_text()
    assert "| coulomb friction, outer: torque |" in text
    (link,) = re.findall(r"\]\((figures/\S+)\)", text)
    assert (out / link).exists()
    assert "coulomb friction, outer: torque" in (out / "compare.html").read_text()
    assert main([*folders, "--out", str(out)]) == 2
    assert "--force" in capsys.readouterr().err
    assert main([*folders, "--out", str(out), "--force"]) == 0


@pytest.mark.parametrize(
    ("count", "others", "words"),
    [(1, [], "at least two"), (0, [], "required"), (1, ["nowhere"], "nowhere/report.json")],
)
def test_fewer_than_two_reports_are_not_compared(folders, refused, count, others, words):
    assert words in refused(main, [*folders[:count], *others])
