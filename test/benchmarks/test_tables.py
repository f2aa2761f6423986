# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tables are written for the terminal and for the page."""

import io

import pytest
from rich.console import Console

from benchmarks._tables import Table, number

TABLE = Table("Two | methods", ("", "time [s]"), [("ours", "1.0"), ("a | b", "12")], "Medians.")


def test_the_page_has_heading_cells_and_notes():
    assert TABLE.as_markdown().splitlines() == [
        "### Two | methods",
        "",
        "|  | time [s] |",
        "| --- | --- |",
        "| ours | 1.0 |",
        r"| a \| b | 12 |",
        "",
        "Medians.",
    ]


def test_the_terminal_has_the_same_cells():
    console = Console(file=io.StringIO(), width=60)
    console.print(TABLE.for_terminal())
    said = console.file.getvalue()
    assert all(word in said for word in ("Two | methods", "time [s]", "ours", "1.0", "a | b", "12", "Medians."))


def test_a_row_that_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="a row has 1 cells, there are 2 columns"):
        Table("title", ("a", "b"), [("1",)])


@pytest.mark.parametrize(
    ("value", "digits", "written"),
    [
        (0.0, 2, "0.0"),
        (1.0, 2, "1.0"),
        (0.994, 2, "0.99"),
        (0.996, 2, "1.0"),
        (9.96, 2, "10"),
        (0.0123, 2, "0.012"),
        (0.00012, 2, "1.2e-04"),
        (172200, 3, "172 000"),
        (14.56, 3, "14.6"),
        (865.2, 2, "870"),
    ],
)
def test_numbers_have_as_many_digits_as_asked(value, digits, written):
    assert number(value, digits) == written
