# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The search's progress for people."""

import io
import itertools

import numpy as np
from rich.console import Console

from cdp_ident.pipeline.progress import SearchDisplay
from cdp_ident.search.genetic_search import Progress


def shown(console, generations, total, seconds=3.0):
    clock = itertools.count(0.0, seconds)
    with SearchDisplay(console, total, lambda: next(clock)) as display:
        for generation in generations:
            display.show(Progress(generation, 10 * generation, np.zeros(9), 1.5))
    return console.file.getvalue()


def test_without_a_terminal_there_are_plain_lines_with_error_and_time_left():
    text = shown(Console(file=io.StringIO(), width=120), range(5), 4)
    assert text.splitlines()[1] == "searching: generation 1 of 4, best error 1.5 rad², about 9 s left"
    assert text.splitlines()[-1] == "fitting: generation 4 of 4, best error 1.5 rad²"


def test_lines_do_not_come_too_often():
    text = shown(Console(file=io.StringIO(), width=120), range(101), 100, seconds=0.1)
    assert len(text.splitlines()) < 8


def test_a_search_without_generations_is_done_at_once():
    assert "fitting" in shown(Console(file=io.StringIO(), width=120), [0], 0)


def test_on_a_terminal_there_is_a_bar():
    text = shown(Console(file=io.StringIO(), width=120, force_terminal=True), range(5), 4)
    assert "━" in text
    assert "\x1b[?25h" in text  # the cursor is shown again


def test_what_is_tried_is_told_now_and_then():
    clock = itertools.count(0.0, 3.0)
    console = Console(file=io.StringIO(), width=120)
    with SearchDisplay(console, 1, lambda: next(clock)) as display:
        for number in range(12):
            display.trying(f"trying this, {number} of 12")
        assert display.doing == "trying this, 11 of 12"
    assert display.doing == ""
    lines = console.file.getvalue().splitlines()
    assert 2 <= len(lines) <= 6
    assert lines[0].startswith("trying this")
