# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The README's moving picture of the demonstration shows the lines that came, in their order."""

import runpy
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parents[2]
SCRIPT = runpy.run_path(str(ROOT / "docs/recording.py"))


def test_lines_come_in_their_order_with_short_waits_and_text_stays_text():
    came = [(10.0, "$ one & <two>"), (10.2, "x" * 150), (310.0, "")]
    shown = SCRIPT["shown"](came)
    assert [line for _, line in shown] == ["$ one & <two>", "x" * 120, "x" * 30, ""]
    assert all(0.0 <= later - sooner <= 1.0 for (sooner, _), (later, _) in pairwise(shown))
    picture = ElementTree.fromstring(SCRIPT["svg"](shown))
    texts = list(picture.iter("{http://www.w3.org/2000/svg}text"))
    assert [(text.text or "").replace("\u00a0", " ") for text in texts] == [line for _, line in shown]


def test_the_picture_in_the_readme_is_small_and_shows_the_end():
    path = ROOT / "docs/demo.svg"
    assert path.stat().st_size < 1_000_000
    assert "docs/demo.svg" in (ROOT / "README.md").read_text()
    assert "hidden\u00a0in\u00a0the\u00a0rig" in path.read_text(encoding="utf-8")
