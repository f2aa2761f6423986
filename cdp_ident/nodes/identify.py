# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Identifies the parameters from bags, reports them, and serves them to other nodes."""

import importlib.util
from pathlib import Path
from typing import Any

from cdp_ident.command_line import ArgumentParser, entry_point, made_of
from cdp_ident.errors import OptionError
from cdp_ident.search.options import METHODS
from cdp_ident.start import loading

DESCRIPTION = """\
Identify the parameters of a cart double pendulum from free-swing bags: find the zero-input motion in each, search,
refine, trace what is left to the effects behind it, and evaluate the result on held-out motion. A folder is written
with report.html to look at, report.md, report.json, and fitted.yaml (a ROS parameter file). Then the fitted
parameters are served until Ctrl-C; with --once it ends, which needs no ROS.

serves     the parameters m1 m2 m0 l1 l2 J1 J2 c1 c2 L g, groups.<group>, std.<each of these>, and the configuration
           ~/identify_again (std_srvs/Trigger)  read configuration and bags again and identify anew, from those that the
           parameter bags then names
           ~/cancel (std_srvs/Trigger)          end the search as Ctrl-C does: its best so far is reported and served
publishes  ~/state (std_msgs/String, latched)   waiting, identifying and how far, ready, or failed and why
           /diagnostics (diagnostic_msgs/DiagnosticArray)  the same, once a second

With --watch, each trial that comes into the folder is checked by the model first, with a warning if it no longer fits,
then fitted jointly with all before it, and the parameters are updated.

Ctrl-C while it searches ends the search: its best so far is fitted, reported and served; once more ends at once."""

EXAMPLE = """\
examples:
  ros2 run cdp_ident identify --bag trials/one --bag trials/two --holdout trials/three --config rig.yaml
  ros2 run cdp_ident identify --bag bags/swing_wide --once
  ros2 run cdp_ident identify --watch trials --config rig.yaml

Configuration (config/identify.yaml lists every key): --config FILE, --ros-args --params-file FILE and
--ros-args -p NAME:=VALUE mean the same; what stands further right here wins, and --method and --seed win over all.
With --once, ROS is needed only for --ros-args."""


_WIDTH = 120


@entry_point
def main(arguments: list[str]) -> int:
    """Run the node."""
    uses_ros_arguments = "--ros-args" in arguments
    options = _parser().parse_args(arguments)
    if options.watch and options.once:
        raise OptionError("--watch goes on until Ctrl-C, so --once cannot go with it")
    with loading("identify"):
        from cdp_ident.pipeline.identifier import NODE_NAME, Identifier, Request
        from cdp_ident.pipeline.interruption import Interruption
        from cdp_ident.report.document import wide_console
    consoles = (wide_console(_WIDTH, stderr) for stderr in (False, True))
    identifier = Identifier(made_of(options, Request), *consoles)
    if options.once and not uses_ros_arguments:
        loaded, interruption = identifier.load({}), Interruption()
        interruption.install()
        try:
            with interruption.identifying():
                identifier.write(identifier.identify(loaded, interruption))
        finally:
            interruption.remove()
        return 0
    _require_ros()
    with loading("identify"):
        from cdp_ident.nodes.identify_node import IdentifyNode
        from cdp_ident.ros.node import run_node
    return run_node(NODE_NAME, lambda node, declared: IdentifyNode(node, declared, identifier, options.once), arguments)


def _require_ros() -> None:
    if importlib.util.find_spec("rclpy") is None:
        raise OptionError("ROS 2 (rclpy) is not here: set it up, or use --once and --config to do without it")


def _parser() -> ArgumentParser:
    parser = ArgumentParser("identify", DESCRIPTION, EXAMPLE)
    bags: dict[str, Any] = {"type": Path, "action": "extend", "nargs": "+", "default": [], "metavar": "DIR"}
    parser.add_argument("--bag", dest="bags", help="rosbag2 bags, fitted jointly", **bags)
    parser.add_argument(
        "--watch",
        type=Path,
        metavar="DIR",
        help="fit the bags in this folder too, and each that the recorder completes there later",
    )
    parser.add_argument(
        "--holdout",
        help="bags that are held out: only the error is measured on them (default: a sixth of each of the others)",
        **bags,
    )
    parser.add_argument(
        "--like", type=Path, metavar="DIR", help="an earlier report of this rig: its effects are tried first"
    )
    parser.add_argument(
        "--effects",
        dest="effects_file",
        metavar="FILE",
        help="YAML file of your own effects, to be looked for beside the catalogue's",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="where the report goes (identification/<bag name>)")
    parser.add_argument("--figures", action="store_true", help="draw the figures as PNG and SVG files, too")
    parser.add_argument("--force", action="store_true", help="replace a report that is there already")
    parser.add_argument(
        "--method", choices=tuple(METHODS), help="the paper's search in full (default: the improved one, cut short)"
    )
    parser.add_argument("--seed", type=int, help="of the search's chance (1)")
    parser.add_argument("--config", type=Path, metavar="FILE", help="ROS parameter file")
    parser.add_argument("--once", action="store_true", help="end when done instead of serving the parameters")
    return parser
