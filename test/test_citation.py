# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""CITATION.cff and REUSE.toml say what package.xml says."""

import xml.etree.ElementTree as ET
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]


def test_it_cites_this_version_under_this_licence():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    package = ET.parse(ROOT / "package.xml")
    assert citation["title"] == package.findtext("name")
    assert citation["version"] == package.findtext("version")
    assert citation["license"] == package.findtext("license")
    assert citation["authors"] == [{"name": package.findtext("author")}]
    reuse = (ROOT / "REUSE.toml").read_text()
    assert f'SPDX-License-Identifier = "{package.findtext("license")}"' in reuse
    assert package.findtext("author") in reuse


def test_it_names_the_paper_as_the_readme_does():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["references"][0]["title"] in (ROOT / "README.md").read_text()
