# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Identifies the bags of many rigs and days, and tells what changed and which rig differs."""

from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point, within
from cdp_ident.errors import OptionError
from cdp_ident.start import loading

DESCRIPTION = """\
Identify the bags of many rigs and days, and look at them together: parameters and effects over time with 95 %
intervals, when something changed, which rig differs from the others and in what.

Bags are looked for in folders and below them, and grouped by the rig whose name the recorder wrote; one without a name
is of the rig of the other bags in its folder, or else of one called as the folder. Each day of a rig, or each bag, is a
piece that is identified as `identify --once` does, in processes on this machine or on a Dask cluster; the result is the
same however many there are. A worker that dies costs its own piece alone, which is tried once more.

Each piece has a report of its own below DIR/pieces, as soon as it is finished. After Ctrl-C, or when bags came or
changed, the same command does what is missing. Then DIR/survey.html and survey.json are written."""

EPILOG = """\
examples:
  ros2 run cdp_ident survey trials --config rig.yaml
  ros2 run cdp_ident survey trials --by bag --workers 8 --out surveys/course
  ros2 run cdp_ident survey /shared/trials --scheduler tcp://10.0.0.1:8786 --out /shared/survey

Exit codes: 0 done; 3 the survey is written, but a piece has no result; 2 bad input; 130 interrupted."""


@entry_point
def main(arguments: list[str]) -> None:
    """Survey the bags."""
    parser = ArgumentParser("survey", DESCRIPTION, EPILOG)
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders with bags in them or below them")
    parser.add_argument("--by", choices=("day", "bag"), default="day", help="what is identified together (day)")
    parser.add_argument(
        "--workers", type=within(1, 1000, int), metavar="N", help="processes on this machine (one for each core)"
    )
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster, such as tcp://10.0.0.1:8786")
    parser.add_argument("--out", type=Path, default=Path("survey"), metavar="DIR", help="where all of it goes (survey)")
    parser.add_argument("--force", action="store_true", help="identify every piece anew, those kept from before too")
    parser.add_argument("--config", type=Path, metavar="FILE", help="ROS parameter file, as for identify")
    options = parser.parse_args(arguments)
    if options.scheduler and options.workers is not None:
        raise OptionError("--workers are on this machine, --scheduler has its own: give one of the two")
    with loading("survey"):
        from cdp_ident.commands._surveying import conduct_survey
    conduct_survey(options)
