"""A report as a document."""

import pytest

from cdp_ident.report.chapters import document_of


@pytest.mark.parametrize(
    ("names", "heading"),
    [
        (["swing_wide", "trial_20261126_093000"], "swing_wide, trial_20261126_093000"),
        (["trial_20261126_093000"], "1 trial of 2026-11-26"),
        (
            ["trial_20261126_093000", "a_20261125_093000", "trial_20261126_093000_2"],
            "3 trials of 2026-11-25, 2026-11-26",
        ),
    ],
)
def test_a_report_is_called_by_its_trials_and_not_by_time_stamps(read_content, names, heading):
    (some, *_) = read_content["trials"]
    read_content["trials"] = [{**some, "role": "fit", "name": name} for name in names]
    assert document_of(read_content).heading == heading


def rows_of(content, chapter, title):
    (parts,) = (each.parts for each in document_of(content).chapters if each.key == chapter)
    return next(part.rows for part in parts if getattr(part, "title", "") == title)


def test_it_is_said_how_sure_an_effect_is_and_what_else_it_could_be(read_content):
    effect = read_content["effects"][0]
    effect["certainty"], effect["evidence"]["probability"] = "probable", 0.875
    effect["also_possible"] = ["air_drag.outer.strips", "joint_spring.outer"]
    (row,) = rows_of(read_content, "effects", "Found and added")
    assert row[3] == "probable, 87.5 %"
    assert row[-1] == "air drag, outer, strips or joint spring, outer"


def test_the_ten_best_of_what_else_was_looked_for_are_told(read_content):
    of_one = {"effect": "air_drag.outer.strips", "log10_odds": -1.0, "probability": 1 / 11}
    read_content["selection"]["candidates"] = [of_one] * 30
    rows = rows_of(read_content, "effects", "What else was looked for")
    assert rows == [("air drag, outer, strips", "0.1 : 1", "9.1 %")] * 10
