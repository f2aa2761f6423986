# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shows the whole way from a rig's serial port to parameters that other nodes read, on this machine."""

import json
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console

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
    from cdp_ident.demo.client_node import client_node  # noqa: PLC0415
    from cdp_ident.demo.processes import Nodes, own_domain  # noqa: PLC0415
    from cdp_ident.demo.recording import RIG, record_trials, swing_times  # noqa: PLC0415
    from cdp_ident.report.document import wide_console  # noqa: PLC0415

    rig = options.rig or RIG
    swing_times(rig)  # refuses an unusable file before anything is made
    out = _new_folder(options.out)
    own_domain()
    console = wide_console(_WIDTH)
    with Nodes(out / "logs") as nodes, client_node(nodes.check) as client:
        console.rule("1  Record three free swings of a rig, here an emulated one", align="left")
        console.print(
            "The driver reads the rig's serial port, the recorder makes a bag of each swing. The rig hangs, a hand\n"
            "leads its rods up, holds them and lets go.\n"
        )
        *fitted, held_out = record_trials(nodes, client, rig, out, partial(console.print, soft_wrap=True))

        console.rule("2  Identify", align="left")
        console.print(
            "It is given the bags and nothing else. It fits the paper's model, beginning with the improved genetic\n"
            "algorithm in full, looks for what the model lacks, and evaluates the result on the last bag.\n"
        )
        command = [
            "--bag",
            *map(str, fitted),
            "--holdout",
            str(held_out),
            "--method",
            "iga",
            "--out",
            str(out / "report"),
        ]
        console.print(f"$ ros2 run cdp_ident identify {shown(' '.join(command))} &\n", soft_wrap=True)
        nodes.start("identify", *command, logged=False)
        states = client.hear("/identify/state")
        client.wait_for("the identification", lambda: any(state.startswith("ready") for state in states), _IDENTIFYING)

        console.rule("3  Ask the node for its parameters, as another node would", align="left")
        for name, value in client.parameters("/identify", ("groups.", "effects.")).items():
            console.print(
                f"$ ros2 param get /identify {name:<46} {value if isinstance(value, str) else f'{value:.6g}'}"
            )
        nodes.stop("identify")

    report = json.loads((out / "report" / REPORT).read_text(encoding="utf-8"))
    console.rule("4  What came of it", align="left")
    _print_result(console, report)
    console.rule("5  Now the rig's secrets are opened", align="left")
    _print_comparison(console, rig, report)
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


def _print_result(console: Console, report: dict[str, Any]) -> None:
    from cdp_ident.report.document import Table, print_table  # noqa: PLC0415
    from cdp_ident.report.searches import shown_generations  # noqa: PLC0415

    history = report["search"]["history"]
    generations = shown_generations(len(history) - 1)
    best = ("E(Z) [rad²]", *(f"{history[generation]:.4g}" for generation in generations))
    console.print(f"The improved genetic algorithm's best error, which {PAGE} draws as a curve:")
    print_table(console, Table("", ("generation", *map(str, generations)), [best]))
    console.print()
    before, after = (report[stage]["error"]["holdout"] for stage in ("before", "after"))
    console.print(report["verdict"])
    console.print("\nOn the trial that no fit has seen, measured against simulated:")
    for name, error in (("the paper's model, fitted", before), ("with the effects found", after)):
        rmse, free_run = 1e3 * error["rmse_rad"], error["sse_free_run"]
        eq10 = "diverges" if free_run is None else f"{free_run:.4g} rad²"
        console.print(f"  {name:<26} {rmse:8.4g} mrad over {error['window_s']:.3g} s   Eq. (10) {eq10}")
    noise = report["noise_rad"]
    console.print(f"  the encoders' noise        {1e3 * noise['theta1']:8.4g} and {1e3 * noise['theta2']:.4g} mrad")


def _print_comparison(console: Console, rig: Path, report: dict[str, Any]) -> None:
    from cdp_ident.demo.comparison import compare  # noqa: PLC0415
    from cdp_ident.report.document import Table, print_table  # noqa: PLC0415

    rows = []
    for name, unit, hidden, found in compare(rig, report):
        off = f"{100 * abs(found / hidden - 1):.2g} %" if hidden and found is not None else ""
        rows.append((name, *("nothing" if value is None else f"{value:.6g}" for value in (hidden, found)), off, unit))
    console.print(f"identify did not read {shown(rig)}, which has the true values:", soft_wrap=True)
    print_table(console, Table("", ("", "hidden in the rig", "found", "off by", "unit"), rows))
    console.print(
        "\nTorques stand over A22 here, as the base parameters do: a free swing does not show by which factor all "
        "masses,\ninertias and torques are larger or smaller. In N m they are given for the masses nearest to the "
        "nominal ones."
    )
