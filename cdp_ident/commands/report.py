"""Draws the report of an identification anew from its numbers and curves."""

from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.report.folder import FIGURES, PAGE, TEXT
from cdp_ident.report.pictures import draw_again

DESCRIPTION = """\
Draw report.html, report.md and figures/ (PNG and SVG) of an identification anew, from the report.json and curves.npz
that identify wrote. Nothing is identified again."""


@entry_point
def main(arguments: list[str]) -> int:
    """Draw the reports."""
    parser = ArgumentParser("report", DESCRIPTION)
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders that identify wrote into")
    for folder in parser.parse_args(arguments).folders:
        problem = draw_again(folder)
        print(problem or f"{folder / PAGE} is drawn")
        print(f"{folder / TEXT} and {FIGURES}/ are drawn")
    return 0
