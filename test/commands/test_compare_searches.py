# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's two algorithms side by side, on the example bags."""

import re
from pathlib import Path

import pytest

from cdp_ident.commands.compare_searches import main

BAGS = Path(__file__).parents[2] / "bags"
SHORT = "/**/identify:\n  ros__parameters: {search: {population: 20, generations: 30}}\n"


@pytest.fixture
def arguments(tmp_path):
    (tmp_path / "short.yaml").write_text(SHORT)
    return ["--seeds", "3", "--config", str(tmp_path / "short.yaml"), "--out", str(tmp_path / "out")]


def test_page_text_and_figures_show_both_algorithms(arguments, tmp_path, capsys):
    assert main(["--bag", str(BAGS / "swing_wide"), *arguments]) == 0
    said = capsys.readouterr().out
    ends = re.findall(r"(?m)^(\S+, seed \d): \S+ rad² after 30 generations", said)
    assert set(ends) == {f"{name}, seed {seed}" for name in ("TGA", "IGA") for seed in (1, 2, 3)}
    text = (tmp_path / "out/compare.md").read_text()
    assert set(re.findall(r"\]\((\S+)\)", text)) == {"figures/evolution.svg", "figures/contrast_1_swing_wide.svg"}
    assert all((tmp_path / "out" / link).exists() for link in re.findall(r"\]\((\S+)\)", text))
    assert "TGA and IGA on swing\\_wide" in text
    assert "TGA and IGA on swing_wide" in (tmp_path / "out/compare.html").read_text()
    assert main(["--bag", str(BAGS / "swing_wide"), *arguments]) == 2
    assert "--force" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "words"), [(["--bag", "nowhere"], "nowhere"), (["--bag", "x", "--seeds", "0"], "--seeds"), ([], "--bag")]
)
def test_bad_input_is_one_line(arguments, refused, given, words):
    assert words in refused(main, [*arguments, *given])
