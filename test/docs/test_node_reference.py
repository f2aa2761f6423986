# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""docs/reference/nodes.md says what the nodes offer and take."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCUMENT = (ROOT / "docs/reference/nodes.md").read_text(encoding="utf-8")


def test_the_document_is_what_the_nodes_say():
    command = [sys.executable, "docs/node_reference.py"]
    made = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert made == DOCUMENT, "python docs/node_reference.py > docs/reference/nodes.md"


@pytest.mark.parametrize("section", DOCUMENT.split("\n## ")[1:], ids=lambda section: section.split("\n", 1)[0])
def test_a_node_s_help_names_all_its_topics_and_services(section):
    _, help_text, table = re.split(r"```(?:text)?", section, maxsplit=2)
    ends = re.findall(r"(?m)^\| (?:publishes|subscribes|serves) \| (\S+) \| (\S+) \|$", table)
    assert ends
    for name, kind in ends:
        assert name in help_text
        assert kind in help_text or name == "/clock"


def test_every_parameter_has_a_meaning():
    rows = re.findall(r"(?m)^\| `([\w.]+)` \| (\w+) \| (.*?) \| (.*?) \| (.*) \|$", DOCUMENT)
    assert len(rows) > 100
    assert [name for name, _, _, _, meaning in rows if not meaning.strip()] == []
