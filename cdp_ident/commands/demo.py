"""Shows the whole way from a bag to parameters that other nodes read, on this machine, in a minute."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from rich.console import Console

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.errors import CdpIdentError, OptionError
from cdp_ident.model.parameters import CONSTANTS, GROUPS, SYMBOLS

DESCRIPTION = """\
Identify the pendulum of the example bags, which is simulated, so that its true parameters are known (bags/README.md),
start the node that serves them, and read them from it as any other node would."""

FITTED, HELD_OUT = ("swing_wide", "swing_folded"), ("swing_check",)
OUT = Path("identification/demo")
_PATIENCE = 120.0
"""Longest wait for the node [s]."""


@entry_point
def main(arguments: list[str]) -> int:
    """Run the demonstration."""
    parser = ArgumentParser("demo", DESCRIPTION)
    parser.add_argument("--bags", type=Path, default=Path("bags"), help="folder of the example bags (bags)")
    parser.add_argument("--out", type=Path, default=OUT, help=f"where the report goes ({OUT})")
    options = parser.parse_args(arguments)
    if not (options.bags / FITTED[0]).is_dir():
        raise OptionError(f"{options.bags} does not hold the example bags: run it where they are, or give --bags")
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # this demonstration is nobody else's

    console = Console(highlight=False, soft_wrap=True)
    command = ["identify", "--bag", *(str(options.bags / name) for name in FITTED)]
    command += ["--holdout", *(str(options.bags / name) for name in HELD_OUT), "--out", str(options.out), "--force"]
    console.rule("1  Identify", align="left")
    console.print(f"$ ros2 run cdp_ident {' '.join(command)}\n")
    node = subprocess.Popen([sys.executable, "-m", "cdp_ident", *command])
    try:
        values = _read_parameters(node)
        console.rule("2  Ask the node for its parameters, as another node would", align="left")
        for name, value in values.items():
            console.print(f"$ ros2 param get /identify {name:<20} {value:.6g}")
    finally:
        # A first Ctrl-C may only end a search that still runs; SIGTERM always ends the node.
        node.send_signal(signal.SIGTERM)
        code = node.wait(_PATIENCE)
    if code != 0:
        raise CdpIdentError(f"the node identify ended with exit code {code}")
    console.rule("3  What remains", align="left")
    console.print(f"{options.out}/report.json  everything, for programs and for the record")
    console.print(f"{options.out}/fitted.yaml  the parameters, for --params-file of other nodes")
    return 0


def _read_parameters(identify: subprocess.Popen[bytes]) -> dict[str, float]:
    """Wait until the node `identify` serves fitted parameters, and return them by name."""
    import rclpy  # noqa: PLC0415 - `demo --help` needs no ROS
    from rclpy.parameter_client import AsyncParameterClient  # noqa: PLC0415

    rclpy.init(args=[])
    try:
        node = rclpy.create_node("demo")
        client = AsyncParameterClient(node, "/identify")

        def result_of(future: Any) -> Any:
            rclpy.spin_until_future_complete(node, future, timeout_sec=1.0)
            return future.result() if future.done() else None

        names = [
            *SYMBOLS,
            *(constant.symbol for constant in CONSTANTS),
            *(f"groups.{group.symbol}" for group in GROUPS),
        ]
        deadline = time.monotonic() + _PATIENCE
        while time.monotonic() < deadline:
            if identify.poll() is not None:
                raise CdpIdentError(f"the node identify ended with exit code {identify.returncode}")
            if not client.services_are_ready():
                time.sleep(0.1)
                continue
            listed = result_of(client.list_parameters())
            if listed and set(names) <= set(listed.result.names):
                answer = result_of(client.get_parameters(names))
                if answer:
                    return {name: value.double_value for name, value in zip(names, answer.values, strict=True)}
            time.sleep(0.2)
        raise CdpIdentError(f"the node identify served no fitted parameters within {_PATIENCE:.0f} s")
    finally:
        rclpy.try_shutdown()
