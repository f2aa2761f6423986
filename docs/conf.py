# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the documents become a site: `make docs`."""

import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
LOGGER = logging.getLogger(__name__)
MOST_WORDS = (120, 60)
"""Of a paragraph, and of one in a list."""

project = "cdp_ident"
author = "cdp_ident maintainers"
version = release = ET.parse(ROOT / "package.xml").findtext("version")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = "cdp_ident"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4

autodoc_typehints = "description"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": True}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
html_show_copyright = False
html_show_sphinx = False


class CommandHelp(SphinxDirective):
    """Shows what a command prints with `--help`."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Run the command."""
        command = [sys.executable, "-m", "cdp_ident", self.arguments[0], "--help"]
        surroundings = {**os.environ, "COLUMNS": "100"}
        said = subprocess.run(command, cwd=ROOT, env=surroundings, check=True, capture_output=True, text=True).stdout
        return [nodes.literal_block(said, said, language="text")]


def refuse_long(app: Any, document: nodes.document) -> None:
    """Warn, which is an error in `make docs`, of paragraphs and list items with more words than people read at once."""
    for paragraph in document.findall(nodes.paragraph):
        words, most = len(paragraph.astext().split()), MOST_WORDS[type(paragraph.parent) is nodes.list_item]
        if words > most:
            LOGGER.warning("%d words together, more than %d: part them", words, most, location=paragraph)


def setup(app: Any) -> None:
    """Make the directive known, and count words."""
    app.add_directive("command-help", CommandHelp)
    app.connect("doctree-read", refuse_long)
