# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shows the whole way from a rig's serial port to parameters that other nodes read, on this machine."""

from datetime import datetime
from functools import partial
from pathlib import Path

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.errors import OptionError
from cdp_ident.outside_text import shown
from cdp_ident.report.folder import PAGE, REPORT

DESCRIPTION = """\
Show the whole way on this machine, in some minutes: an emulated rig on a real serial port, the driver that reads
it, the recorder that makes bags of three free swings (two to fit, one held out), and identify, which is given
nothing but the bags, finds what the rig has beside the paper's model, and serves the result to other nodes. Each node
is a process of its own, on a ROS domain of the demonstration's own; at the end all are stopped."""

_IDENTIFYING = 600.0
"""Longest wait for identify [s]: the first time it also compiles."""
_WIDTH = 120
"""Where there is no terminal, as `identify` has it."""


@entry_point
def main(arguments: list[str]) -> int:
    """Run the demonstration."""
    parser = ArgumentParser("demo", DESCRIPTION)
    parser.add_argument("--rig", type=Path, metavar="FILE", help="another emulated rig (config/emulated_rig.yaml)")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="where everything goes; must not exist (identification/demo_<time>)"
    )
    options = parser.parse_args(arguments)
    # What follows needs ROS, which `demo --help` does not.
    from cdp_ident.demo.comparison import print_comparison, print_result  # noqa: PLC0415
    from cdp_ident.demo.nodes import Nodes, own_domain  # noqa: PLC0415
    from cdp_ident.demo.recording import RIG, record_trials, swing_times  # noqa: PLC0415
    from cdp_ident.report.document import wide_console  # noqa: PLC0415
    from cdp_ident.report.report_file import read_report  # noqa: PLC0415

    rig = options.rig or RIG
    swing_times(rig)  # refuses an unusable file before anything is made
    out = _new_folder(options.out)
    own_domain()
    console = wide_console(_WIDTH)
    with Nodes(out / "logs") as nodes:
        console.rule("1  Record three free swings of a rig, here an emulated one", align="left")
        console.print(
            "The driver reads the rig's serial port, the recorder makes a bag of each swing. The rig hangs, a hand\n"
            "leads its rods up, holds them and lets go.\n"
        )
        *fitted, held_out = record_trials(nodes, rig, out, partial(console.print, soft_wrap=True))

        console.rule("2  Identify", align="left")
        console.print(
            "It is given the bags and nothing else. It fits the paper's model, beginning with the improved genetic\n"
            "algorithm in full, looks for what the model lacks, and evaluates the result on the last bag.\n"
        )
        bags = ("--bag", *map(str, fitted), "--holdout", str(held_out))
        command = [*bags, "--method", "iga", "--out", str(out / "report")]
        console.print(f"$ ros2 run cdp_ident identify {shown(' '.join(command))} &\n", soft_wrap=True)
        nodes.start("identify", *command, logged=False)
        states = nodes.hear("/identify/state")
        nodes.wait_for("the identification", lambda: any(state.startswith("ready") for state in states), _IDENTIFYING)

        console.rule("3  Ask the node for its parameters, as another node would", align="left")
        for name, value in nodes.parameters("/identify", ("groups.", "effects.")).items():
            console.print(
                f"$ ros2 param get /identify {name:<46} {value if isinstance(value, str) else f'{value:.6g}'}"
            )
        nodes.stop("identify")

    report = read_report(out / "report" / REPORT)
    console.rule("4  What came of it", align="left")
    print_result(console, report)
    console.rule("5  Now the rig's secrets are opened", align="left")
    print_comparison(console, rig, report)
    console.print(f"\nThe bags, the report and what each node said are in {shown(out)}. Open in a browser:")
    console.print(shown(out / "report" / PAGE), soft_wrap=True)
    return 0


def _new_folder(asked: Path | None) -> Path:
    """Make the folder for everything. Raises `OptionError` where it is there already or cannot be made."""
    folder = asked or Path("identification") / f"demo_{datetime.now().astimezone():%Y%m%d_%H%M%S}"
    try:
        folder.mkdir(parents=True)
    except FileExistsError as error:
        raise OptionError(f"{folder} is there already: give --out a new name") from error
    except OSError as error:
        raise OptionError(f"{folder} cannot be made: {error.strerror or error}; give another --out") from error
    return folder
