# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Puts the results of several identifications side by side."""

from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.output_folder import check_folder
from cdp_ident.report.folder import COMPARISON_PAGE, COMPARISON_TEXT
from cdp_ident.start import loading

DESCRIPTION = """\
Put the results of several identifications side by side, as before and after a bearing was changed: errors, base
parameters, effects and physical values, and how far they differ from the first in standard deviations. With --out,
also as compare.html and compare.md."""


@entry_point
def main(arguments: list[str]) -> None:
    """Compare the reports."""
    parser = ArgumentParser("compare", DESCRIPTION)
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders that identify wrote into")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where compare.html, compare.md and a figure go")
    parser.add_argument("--force", action="store_true", help="replace a comparison that is there already")
    options = parser.parse_args(arguments)
    with loading("compare"):
        from cdp_ident.commands._comparison import show_comparison
        from cdp_ident.report.comparison import compare, read_runs
        from cdp_ident.report.parameters import runs_compared
    if options.out:
        check_folder(options.out, options.force, (COMPARISON_PAGE, COMPARISON_TEXT))
    runs = read_runs(options.folders)
    show_comparison(", ".join(runs), compare(runs), [runs_compared(runs)], options.out, options.force)
