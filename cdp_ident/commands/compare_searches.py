# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Puts the paper's two genetic algorithms side by side on bags."""

from functools import partial
from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point, within
from cdp_ident.output_folder import check_folder
from cdp_ident.report.folder import COMPARISON_PAGE, COMPARISON_TEXT
from cdp_ident.start import loading

DESCRIPTION = """\
Put the paper's traditional and its improved genetic algorithm (TGA, IGA) side by side on the first 10 s of each bag:
how the best error evolves over the generations, with several seeds each, the best chromosomes by generation,
and how a typical search of each follows the motion. Writes compare.html, compare.md and figures."""

EXAMPLE = """\
example:
  ros2 run cdp_ident compare_searches --bag bags/swing_wide

A search in full takes some seconds for each bag. search.generations and all else that --config may hold is that of
identify."""


@entry_point
def main(arguments: list[str]) -> None:
    """Search by both, and compare."""
    parser = ArgumentParser("compare_searches", DESCRIPTION, EXAMPLE)
    parser.add_argument(
        "--bag", type=Path, nargs="+", required=True, metavar="DIR", help="rosbag2 bags, searched jointly"
    )
    parser.add_argument(
        "--seeds", type=within(1, 1000, int), default=10, metavar="N", help="searches by each algorithm (10)"
    )
    parser.add_argument("--config", type=Path, metavar="FILE", help="ROS parameter file, as for identify")
    parser.add_argument("--out", type=Path, default=Path("searches"), metavar="DIR", help="where it goes (searches)")
    parser.add_argument("--force", action="store_true", help="replace a comparison that is there already")
    options = parser.parse_args(arguments)
    with loading("compare_searches"):
        from cdp_ident.commands._comparison import show_comparison
        from cdp_ident.configuration.settings import without_results
        from cdp_ident.pipeline.identifier import read_configuration
        from cdp_ident.pipeline.searches import search_by_both
        from cdp_ident.pipeline.searches_page import search_figures, search_tables
    check_folder(options.out, options.force, (COMPARISON_PAGE, COMPARISON_TEXT))
    given, _ = without_results(read_configuration(options.config))
    found = search_by_both(options.bag, given, options.seeds, partial(print, flush=True))
    heading = f"TGA and IGA on {', '.join(found.trials)}"
    show_comparison(heading, search_tables(found), list(search_figures(found)), options.out, options.force)
