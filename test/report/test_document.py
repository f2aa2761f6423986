# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A report as a document, and the document as text: at a terminal, and as Markdown."""

import io
import re

import pytest
from rich.console import Console

from cdp_ident.report.chapters import document_of
from cdp_ident.report.document import Chapter, Charts, Code, Document, Sentences, Table, markdown, print_document
from cdp_ident.report.figures.description import Axis, Figure, Panel
from cdp_ident.report.wording import summary, with_std

FIGURE = Figure("one", "Errors", "How large.", [Panel(Axis(), Axis("m"), [])])
NOTHING = {"interrupted": False, "looked_in_s": 0.0, "steps": [], "candidates": []}


@pytest.mark.parametrize(
    ("change", "gone"),
    [
        ({"prediction": None}, {"prediction"}),
        ({"next_trial": None}, {"next_trial"}),
        ({"repeatability": None}, {"repeatability"}),
        ({"selection": NOTHING}, {"selection", "candidates"}),
    ],
)
def test_what_there_is_nothing_of_has_no_figure(read_content, shown_curves, change, gone):
    names = {figure.name for figure in document_of(read_content, shown_curves).figures}
    left = {figure.name for figure in document_of(read_content | change, shown_curves).figures}
    assert names - left == gone


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


def printed(content):
    stream = io.StringIO()
    print_document(Console(file=stream, width=150), document_of(content))
    return stream.getvalue()


def test_the_tables_hold_the_report_s_numbers(content):
    text = printed(content)
    errors = content["stages"]
    for stage in errors.values():
        assert f"{1e3 * stage['holdout']['rmse_rad']:.4g}" in text
    assert with_std(content["after"]["physical"]["l2"]["value"], content["after"]["physical"]["l2"]["std"]) in text
    assert "no: nearest to nominal" in text
    assert "given" in text
    assert all(sentence[1:40] in text for sentence in content["identifiability"]["words"])
    assert "dry friction (outer joint)" in text


def test_a_report_read_from_its_file_gives_the_same_text(content, read_content):
    assert printed(read_content) == printed(content)


def test_errors_of_time_stand_beside_the_noise(read_content):
    assert "errors of" not in printed(read_content)
    read_content["whole_swings"]["time_noise_s"] = 1.2e-3
    assert "mrad, with errors of 1.2 ms in the times of both encoders" in printed(read_content)


def test_warnings_are_printed(read_content):
    read_content["warnings"] = []
    assert "Warnings\nNone." in re.sub(" +\n", "\n", printed(read_content))
    read_content["warnings"] = [{"name": "x", "about": [], "message": "the sky is falling"}]
    assert "the sky is falling" in printed(read_content)


def test_what_a_bag_is_called_is_printed_as_it_is(read_content):
    read_content["trials"][0]["bag"] = "bags/[red]swing[/]"
    read_content["repeatability"]["trials"][0]["trial"] = "[bold]x"
    assert "[red]swing[/]" in printed(read_content)
    assert "[bold]x" in printed(read_content)


def test_the_summary_is_the_verdict_on_the_fitted_trials(content):
    assert content["verdict"] in summary(content)
    assert content["trials"][0]["name"] in summary(content)


def as_markdown(*parts, with_figures=False):
    return markdown(Document("", "a_b", "All is well.", [Chapter("x", "Chapter", parts)]), with_figures)


@pytest.mark.parametrize(
    ("part", "text"),
    [
        (
            Table("Sizes", ("what", "size"), [("rod", "1")], "In m."),
            "\n\n## Chapter\n\n**Sizes**\n\n| what | size |\n| --- | --- |\n| rod | 1 |\n\nIn m.\n",
        ),
        (Sentences(["One."]), "\n\nOne.\n"),
        (Sentences(["One.", "Two."]), "- One.\n- Two.\n"),
        (Sentences(["*a* <b>"]), "\\*a\\* &lt;b>"),
        (Sentences([Code("run *a*")]), "`run *a*`"),
    ],
)
def test_a_part_is_markdown_in_which_text_stays_text(part, text):
    assert text in as_markdown(part)


def test_a_chapter_that_says_nothing_is_left_out():
    nothing = (Table("", ("a",), []), Sentences([]), Charts([FIGURE]))
    assert as_markdown(*nothing) == "# a\\_b\n\nAll is well.\n"
    assert "![Errors. m: .](figures/one.svg)" in as_markdown(*nothing, with_figures=True)
