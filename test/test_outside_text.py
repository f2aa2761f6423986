# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Text from outside is shown on one line, without what commands a terminal or turns the direction of writing."""

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.outside_text import LONGEST, shown


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("swing ä 1", "swing ä 1"),
        ("a\n\tb", "a b"),
        ("\x1b]0;title\x07red", r"\x1b]0;title\x07red"),
        ("abc\u202egnp.exe", r"abc\u202egnp.exe"),
        (os.fsdecode(b"swing\xff"), r"swing\xff"),
        (ValueError("a\0b"), r"a\x00b"),
    ],
)
def test_what_is_not_to_be_shown_is_escaped(text, line):
    assert shown(text) == line


def test_of_a_long_text_the_middle_is_left_out():
    line = shown("a" * 10**7 + "end", 30)
    assert len(line) == 30
    assert line.endswith("end")
    assert "…" in line


@given(st.text(st.characters(exclude_categories=()), max_size=2000))
def test_any_text_becomes_one_line_that_can_be_written(text):
    line = shown(text)
    line.encode()
    assert len(line) <= LONGEST
    assert line.isprintable() or not line.strip() or all(c.isprintable() or c == " " for c in line if ord(c) < 0x300)
