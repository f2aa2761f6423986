# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Prints docs/reference/nodes.md from the nodes themselves: each is made, and asked what it offers and takes.

python docs/node_reference.py > docs/reference/nodes.md
"""

import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.parameter import Parameter
from rich.console import Console

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from cdp_ident.configuration.described import Described  # noqa: E402
from cdp_ident.configuration.settings import KEYS  # noqa: E402
from cdp_ident.nodes import driver, emulator, identify, identify_node, recorder, simulator  # noqa: E402
from cdp_ident.pipeline.identifier import Identifier, Request  # noqa: E402
from cdp_ident.rig.emulator.cable import Faults  # noqa: E402
from cdp_ident.rig.emulator.configuration import EmulatedRig  # noqa: E402
from cdp_ident.rig.emulator.emulation import Emulation, Events  # noqa: E402
from cdp_ident.rig.protocol import BinaryCodec  # noqa: E402
from cdp_ident.ros.parameters import Parameters  # noqa: E402

NAMESPACE = "/somewhere"
"""In which the nodes are made: names outside it are absolute ones."""
_OF_EVERY_NODE = (
    "/rosout",
    "/parameter_events",
    "_type_description",
    "_parameters",
    "_parameter_types",
    "_parameters_atomically",
)
"""Ends of names that rclpy gives to every node."""
HEAD = """\
# Nodes: topics, services, parameters

This page is made from the nodes themselves (`python docs/node_reference.py > docs/reference/nodes.md`); a test compares
it with them.

Names are relative to the node's namespace, `~/` stands for the node's own name, and names that begin with `/` are the
same for all nodes. A parameter that is *changeable* may be set while the node runs; all others are set at its start, by
`--ros-args -p NAME:=VALUE` or `--params-file FILE`, and are read-only from then on. `ros2 param describe NODE NAME`
shows the same of a running node.
"""


class Declared(Parameters):
    """The parameters of a node, which notes what is declared."""

    def __init__(self, node: Any) -> None:
        super().__init__(node, [])
        self.declared: dict[str, Described] = {}

    def declare(self, name: str, default: Any, description: str, **of: Any) -> Any:
        """Declare a parameter, and note it."""
        self.declared[name] = Described(name, default, description, **of)
        return super().declare(name, default, description, **of)

    def show(self, parameters: Iterable[Described], gone: Iterable[str] = ()) -> None:
        """Show parameters, and note them."""
        parameters = tuple(parameters)
        self.declared |= {shown.name: shown for shown in parameters}
        super().show(parameters, gone)


Make = Callable[[Any, Declared], Any]
Form = tuple[Make, dict[str, Any]]
"""How a node is made, and the parameters that it is given."""
Row = tuple[str, ...]


def offered(name: str, make: Make, given: dict[str, Any]) -> tuple[set[Row], dict[str, Described]]:
    """Make a node; return rows of direction, name and type of its topics and services, and its parameters."""
    overrides = [Parameter(parameter, value=value) for parameter, value in given.items()]
    node = rclpy.create_node(name, namespace=NAMESPACE, parameter_overrides=overrides)
    parameters = Declared(node)
    body = make(node, parameters)
    ends = [("publishes", p.topic_name, p.msg_type) for p in node.publishers]
    ends += [("subscribes", s.topic_name, s.msg_type) for s in node.subscriptions]
    ends += [("serves", s.srv_name, s.srv_type) for s in node.services]
    body.close()
    node.destroy_node()
    own = f"{NAMESPACE}/{name}/"
    return {
        (how, _relative(topic, own), f"{kind.__module__.split('.')[0]}/{kind.__name__}")
        for how, topic, kind in ends
        if not _relative(topic, own).endswith(_OF_EVERY_NODE) and "/_" not in topic
    }, parameters.declared


def _relative(name: str, own: str) -> str:
    if name.startswith(own):
        return f"~/{name.removeprefix(own)}"
    return name.removeprefix(f"{NAMESPACE}/")


def page(folder: Path) -> str:
    """Return the page; `folder` is for what nodes write when they are made."""

    def emulate(node: Any, _: Declared) -> Any:
        emulation = Emulation(
            EmulatedRig(), folder / "rig", BinaryCodec(), np.random.default_rng(0), Faults(), Events(), speed=2.0
        )
        return emulator.Emulator(node, emulation)

    def watch(node: Any, parameters: Declared) -> Any:
        request = Request((), (), folder / "out", None, None, None, False, watch=folder)
        quiet = Console(quiet=True)
        return identify_node.IdentifyNode(node, parameters, Identifier(request, quiet, quiet), once=False)

    def replay(node: Any, parameters: Declared) -> Any:
        return simulator.Simulator(node, parameters, ROOT / "bags/swing_check", None, False)

    def alone(node: Any, parameters: Declared) -> Any:
        return simulator.Simulator(node, parameters, None, None, False)

    parts: list[tuple[str, str, Sequence[Form]]] = [
        ("driver", driver.DESCRIPTION, [(driver.Driver, {})]),
        ("recorder", recorder.DESCRIPTION, [(recorder.RecorderNode, {})]),
        ("identify", identify.DESCRIPTION, [(watch, {})]),
        ("simulator", simulator.DESCRIPTION, [(replay, {"clock": True}), (alone, {"mode": "shadow"}), (alone, {})]),
        ("emulator", emulator.DESCRIPTION, [(emulate, {})]),
    ]
    text = HEAD
    for name, description, forms in parts:
        ends: set[Row] = set()
        parameters: dict[str, Described] = {}
        for make, given in forms:
            more, parameters = offered(name, make, given)
            ends |= more
        text += f"\n## {name}\n\n```text\n{description}\n```\n\n{_table(('', 'name', 'type'), sorted(ends))}"
        if name == "identify":
            parameters = KEYS
        rows = [_parameter(shown) for shown in parameters.values()]
        if rows:
            text += "\n" + _table(("parameter", "type", "unit", "default", "meaning"), rows)
    return text


def _parameter(shown: Described) -> Row:
    value = shown.value
    kind = {bool: "bool", int: "integer", float: "double", str: "string", list: "list"}.get(type(value), "double")
    default = (
        ""
        if value is None
        else str(value).lower()
        if kind == "bool"
        else f"{value:g}"
        if kind == "double"
        else str(value)
    )
    default = default.replace(str(Path.home()), "~").replace(f"{NAMESPACE.strip(chr(47))}.", "")
    allowed = shown.constraint.removesuffix(f" {shown.unit}") if shown.unit else shown.constraint
    meaning = "; ".join(filter(None, (shown.description, allowed, "changeable" if shown.changeable else "")))
    return f"`{shown.name}`", kind, shown.unit, f"`{default}`" if default else "", meaning


def _table(titles: Sequence[str], rows: Iterable[Row]) -> str:
    lines = ["| " + " | ".join(titles) + " |", "|" + "---|" * len(titles)]
    lines += ["| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the page."""
    rclpy.init()
    rclpy.logging.set_logger_level(NAMESPACE.strip("/"), rclpy.logging.LoggingSeverity.FATAL)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # a recorder makes its folder where it is started
        text = page(Path(folder))
        os.chdir(ROOT)
    rclpy.try_shutdown()
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
