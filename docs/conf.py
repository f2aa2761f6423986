"""How the documents become a site: `make docs`."""

import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

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


def setup(app: Any) -> None:
    """Make the directive known."""
    app.add_directive("command-help", CommandHelp)
