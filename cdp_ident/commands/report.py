# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draws the report of an identification anew from its numbers and curves."""

from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.outside_text import shown
from cdp_ident.report.folder import FIGURES, PAGE, TEXT
from cdp_ident.start import loading

DESCRIPTION = """\
Draw report.html and report.md of an identification anew, from the report.json and curves.npz that identify wrote; with
--figures also figures/ (PNG and SVG), to which report.md links then. Nothing is identified again."""


@entry_point
def main(arguments: list[str]) -> None:
    """Draw the reports."""
    parser = ArgumentParser("report", DESCRIPTION)
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders that identify wrote into")
    parser.add_argument("--figures", action="store_true", help="draw the figures as PNG and SVG, too")
    options = parser.parse_args(arguments)
    with loading("report"):
        from cdp_ident.report.pictures import draw
    for folder in options.folders:
        draw(folder, options.figures)
        place = shown(folder)
        print(f"{place}/{PAGE} is drawn")
        print(f"{place}/{TEXT} and {FIGURES}/ are drawn" if options.figures else f"{place}/{TEXT} is drawn")
