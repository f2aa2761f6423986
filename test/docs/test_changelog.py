# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""CHANGELOG.rst: what is not released, then one version after the other, a page each."""

import re
import xml.etree.ElementTree as ET
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[2]
_WORDS = 1100
"""Of a page."""
_VERSION = re.compile(r"(\d+)\.(\d+)\.(\d+) \((\d{4}-\d\d-\d\d)\)")


def test_versions_are_a_page_each_the_newest_first_and_that_is_the_package_s() -> None:
    _, *parts = re.split(r"\n(.+)\n-{5,}\n", (ROOT / "CHANGELOG.rst").read_text())
    (newest, *_), changes = parts[::2], parts[1::2]
    assert newest == "Forthcoming"
    versions = [_VERSION.fullmatch(title) for title in parts[2::2]]
    assert all(versions)
    found = [(tuple(map(int, version.groups()[:3])), date.fromisoformat(version[4])) for version in versions if version]
    assert found == sorted(found, reverse=True)
    assert [len(words) for text in changes[1:] if len(words := text.split()) > _WORDS] == []
    released = ".".join(map(str, found[0][0]))
    assert ET.parse(ROOT / "package.xml").findtext("version") == released
    assert f'version="{released}"' in (ROOT / "setup.py").read_text()
