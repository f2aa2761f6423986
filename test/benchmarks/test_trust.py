# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page on trust says what a campaign of truths gave."""

import json

import pytest

from benchmarks import trust


def result(group="single", **changed):
    return {
        "group": group, "engine": "equations", "error": "", "named": ["air_drag.inner"], "probability": [0.98],
        "right": ["air_drag.inner"], "missed": [], "weak": [], "beyond": [], "false": [], "unknown": [],
        "before": 4.0, "after": 1.0, "deviations": [0.1, -1.0, 2.5, 0.0, 1.9],
    } | changed  # fmt: skip


WRONG = result(
    "beyond",
    named=["joint_spring.outer"] * 2,
    probability=[0.6, 0.8],
    right=[],
    false=["joint_spring.outer"],
    beyond=["magnet.outer"],
    unknown=["unknown_torque.outer"],
)


def test_names_are_counted_by_the_probability_that_was_said_and_intervals_by_group():
    """A name is right unless it is among the false ones."""
    assert trust.names([result(), WRONG]) == [(0.98, True), (0.6, False), (0.8, True)]
    assert trust.reliability([result()] * 3 + [WRONG]).rows == [
        ("0.5 to 0.7", "60.0 %", "0 of 1"), ("0.7 to 0.9", "80.0 %", "1 of 1"), ("0.9 to 0.99", "98.0 %", "3 of 3"),
    ]  # fmt: skip
    assert trust.coverage([result()]).rows == [("single", "5", "80 ± 0 %")]


@pytest.mark.parametrize(
    ("of", "pairs"),
    [
        (result(), [("air_drag", "air_drag")]),
        (result("none", named=[], probability=[], right=[]), [("nothing", "nothing")]),
        (result("none", right=[], false=["backlash.inner"]), [("nothing", "backlash")]),
        (result(right=[], missed=["air_drag.inner"]), [("air_drag", "nothing")]),
        (WRONG, [("magnet", "joint_spring"), ("nothing", "a nonparametric torque")]),
    ],
)
def test_what_was_hidden_stands_beside_what_was_found_for_it(of, pairs):
    assert trust._pairs(of) == pairs


def test_the_page_and_its_pictures_are_made(tmp_path, monkeypatch):
    page = tmp_path / "trust.md"
    page.write_text(f"# Trust\n\n{trust.BEGIN}\nearlier numbers\n{trust.END}\n\nthe end\n")
    monkeypatch.setattr(trust, "PAGE", page)
    monkeypatch.setattr(trust, "PICTURES", tmp_path / "trust")
    lines = "".join(json.dumps(of) + "\n" for of in (result(), WRONG, result(error="gone")))
    (tmp_path / "truths.jsonl").write_text(lines)
    (tmp_path / "a_rig").mkdir()
    errors = {key: {"error": {"holdout": {"rmse_rad": size}}} for key, size in (("before", 2e-3), ("after", 1e-3))}
    (tmp_path / "a_rig/report.json").write_text(json.dumps(errors | {"noise_rad": {"theta1": 1e-4, "theta2": 1e-4}}))
    trust.main([str(tmp_path / "truths.jsonl"), "--reports", str(tmp_path / "a_rig"), "--write"])
    text = page.read_text()
    assert "2 truths (2 by equations)" in text
    assert "| a rig | 2 | 1 | 0.1 |" in text
    assert "earlier numbers" not in text
    assert text.endswith("the end\n")
    assert {path.name for path in (tmp_path / "trust").iterdir()} == {
        "names.svg", "confusion.svg", "errors.svg", "coverage.svg", "measured.svg",
    }  # fmt: skip
