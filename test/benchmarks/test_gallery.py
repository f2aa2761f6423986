# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The gallery of effects: all of the catalogue is in it, and its page is that of what was found."""

import re

from benchmarks._gallery_page import Strengths, page, read_entries
from benchmarks.gallery import DRAWN, FOUND, KINDS, PAGE, PICTURES, STRONG, WEAKER
from cdp_ident.model.effects.catalogue import CATALOGUE

TEXT = PAGE.read_text(encoding="utf-8")


def test_every_effect_of_the_catalogue_has_a_section_and_no_other_one():
    names = {effect.name.replace("_", " ").capitalize() for effect in CATALOGUE}
    assert sorted(re.findall(r"(?m)^## (.+)$", TEXT)) == sorted(names)


def test_everything_that_was_hidden_has_a_picture():
    assert {path.stem for path in PICTURES.glob("*.svg")} == set(KINDS)
    assert all(f"](effects/{kind}.svg)" in TEXT for kind in KINDS)


def test_the_page_is_that_of_what_was_found():
    assert page(read_entries(FOUND), Strengths(DRAWN, STRONG, WEAKER[0], WEAKER[-1])) == TEXT, (
        "python -m benchmarks.gallery --draw"
    )
