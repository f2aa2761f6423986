# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Say which swing to record next: `suggest DIR`."""

from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point, within
from cdp_ident.start import loading

DESCRIPTION = """\
Say from where to let both rods go next, and with which weight on them, so that a trial of the same length tells most
of what is asked, and what it would bring. Angles are from hanging, positive towards +x. DIR is a folder that identify
wrote its report into."""

EXAMPLE = """\
examples:
  ros2 run cdp_ident suggest identification/one
  ros2 run cdp_ident suggest identification/one --for c2_over_A22
  ros2 run cdp_ident suggest identification/one --between coulomb_friction.outer load_friction.outer
  ros2 run cdp_ident suggest identification/one --for A22 --weight outer=0.05,0.30

Without --for and --between: effects that could be others, all base parameters, each effect's strength, and A22.
docs/how_to/next_trial.md tells how the start is chosen."""


@entry_point
def main(arguments: list[str]) -> None:
    """Print the starts to take."""
    parser = ArgumentParser("suggest", DESCRIPTION, EXAMPLE)
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of a report")
    parser.add_argument(
        "--for", dest="wanted", action="append", default=[], metavar="NAME",
        help="what to determine better: all base parameters (all), one of them, A22, or an effect or its parameter; "
        "may be given again",
    )  # fmt: skip
    parser.add_argument(
        "--between",
        nargs=2,
        metavar=("A", "B"),
        help="two effects to tell apart, as coulomb_friction.outer; one is in the model",
    )
    parser.add_argument(
        "--weight",
        dest="weights",
        action="append",
        default=[],
        metavar="ROD=MASS,PLACE[,INERTIA]",
        help="one that could be clamped to a rod, as the recorder's added.ROD has it [kg, m from the rod's own joint, "
        "kg m^2]: starts are tried with it too, and with those of the trials; may be given again for another",
    )
    parser.add_argument(
        "--weight-std",
        metavar="MASS,PLACE",
        help="how well mass and place of these weights are known, as added_std.ROD [kg, m] (1 %% of the mass, 1 mm)",
    )
    parser.add_argument(
        "--spacing", type=within(5, 90), default=15.0, metavar="DEG", help="of the starts that are tried (15)"
    )
    for most in ("--most-inner", "--most-outer"):
        parser.add_argument(most, type=within(0, 180), default=180.0, metavar="DEG", help="furthest from hanging (180)")
    options = parser.parse_args(arguments)
    with loading("suggest"):
        from cdp_ident.commands._suggestions import print_suggestions
    print_suggestions(options)
