# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of all comparisons."""

import importlib

from benchmarks import __main__ as command
from benchmarks import _page
from benchmarks._page import COMPARISONS, PAGE, Section, Surroundings, page, section, topics
from benchmarks._tables import Table

WHERE = Surroundings("a processor, 2 cores", "Python 3.12", "1 June 2024", "0.1 when it began, 2.0 when it ended")


def comparison(topic):
    return importlib.import_module(f"benchmarks.{topic}")


def table(word):
    return Table("Times", ("", "time [s]"), [(word, "1.0")])


def headings(text):
    return [line[3:] for line in text.splitlines() if line.startswith("## ")]


def test_every_comparison_has_its_section_in_the_page_that_is_there():
    text = PAGE.read_text()
    expected = [_page.documented(topic)[0].rstrip(".") for topic in COMPARISONS]
    assert headings(text) == [*expected, "What takes longer"]
    assert "No result" not in text


def test_studies_are_told_of_with_how_to_run_them():
    text = page([], WHERE)
    for topic in topics():
        assert (f"`python -m benchmarks.{topic}`" in text) == (topic not in COMPARISONS)


def test_the_page_says_where_and_when_and_how_busy():
    text = page([Section("One.", "About it.", [table("ours")])], WHERE)
    assert all(part in text for part in (WHERE.machine, WHERE.versions, WHERE.date, WHERE.load, "a full run"))
    assert "## One\n\nAbout it.\n\n### Times\n\n" in text


def test_a_comparison_that_fails_costs_itself_alone(monkeypatch, tmp_path):
    def fail(quick):
        raise ArithmeticError("what is compared differs\nby 1")

    for topic in COMPARISONS:
        monkeypatch.setattr(comparison(topic), "tables", lambda quick, topic=topic: [table(f"{topic} {quick}")])
    monkeypatch.setattr(comparison("cost"), "tables", fail)
    monkeypatch.setattr(command, "PAGE", tmp_path / "benchmarks.md")
    assert command.main(["--quick"]) == 1
    text = (tmp_path / "benchmarks.md").read_text()
    assert "No result this time: what is compared differs by 1" in text
    assert "a quick run" in text
    for topic in COMPARISONS:
        assert (f"| {topic} True | 1.0 |" in text) == (topic != "cost")


def test_a_part_alone_leaves_the_page_as_it_is(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(comparison("bag"), "tables", lambda quick: [table(f"bag {quick}")])
    monkeypatch.setattr(command, "PAGE", tmp_path / "benchmarks.md")
    assert command.main(["bag"]) == 0
    assert "bag False" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())


def test_an_unknown_name_is_refused(capsys):
    assert command.main(["serach"]) == 2
    assert "search" in capsys.readouterr().err


def test_what_went_wrong_is_said_in_a_line(monkeypatch):
    def fail(quick):
        raise RuntimeError

    monkeypatch.setattr(comparison("cost"), "tables", fail)
    assert section("cost", quick=True).failure == "RuntimeError"
