"""Puts the results of several identifications side by side."""

from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.report.folder import COMPARISON_PAGE, COMPARISON_TEXT, FIGURES, check_folder, write_files
from cdp_ident.start import loading

DESCRIPTION = """\
Put the results of several identifications side by side, as before and after a bearing was changed: errors, base
parameters, effects and physical values, and how far they differ from the first in standard deviations. With --out,
also as compare.html and compare.md."""

_WIDTH = 140
"""Where there is no terminal."""


@entry_point
def main(arguments: list[str]) -> int:
    """Compare the reports."""
    parser = ArgumentParser("compare", DESCRIPTION)
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders that identify wrote into")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where compare.html, compare.md and a figure go")
    parser.add_argument("--force", action="store_true", help="replace a comparison that is there already")
    options = parser.parse_args(arguments)
    with loading("compare"):
        from rich.console import Console

        from cdp_ident.report.comparison import compare, read_runs
        from cdp_ident.report.pictures import draw_comparison
        from cdp_ident.report.terminal import print_tables
    if options.out:
        check_folder(options.out, options.force, (COMPARISON_PAGE, COMPARISON_TEXT))
    runs = read_runs(options.folders)
    console = Console(highlight=False, markup=False)
    console = console if console.is_terminal else Console(highlight=False, markup=False, width=_WIDTH)
    print_tables(console, compare(runs))
    if options.out:
        drawn = draw_comparison(runs)
        write_files(options.out, drawn.files)
        console.print(drawn.problem or f"{options.out / COMPARISON_PAGE} is written", soft_wrap=True)
        console.print(f"{options.out / COMPARISON_TEXT} and {FIGURES}/ are written", soft_wrap=True)
    return 0
