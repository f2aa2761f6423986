# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Behaves like a rig on a serial port: for demonstrations, tests, and work without the rig."""

import argparse
import threading
import time
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import rclpy.time
from rosgraph_msgs.msg import Clock

from cdp_ident.command_line import ArgumentParser, entry_point, made_of, within
from cdp_ident.configuration.described import field_documentation
from cdp_ident.errors import CdpIdentError
from cdp_ident.outside_text import shown
from cdp_ident.rig.emulator.cable import Faults
from cdp_ident.rig.emulator.configuration import EmulatedRig, load_rig
from cdp_ident.rig.emulator.emulation import Emulation, Events
from cdp_ident.rig.protocol import CODECS
from cdp_ident.ros.node import parse_arguments, run_node
from cdp_ident.ros.parameters import Parameters
from cdp_ident.user_input import limits_of

DESCRIPTION = """\
Emulate a rig: a serial port (a pseudo-terminal behind --link) that speaks docs/reference/protocol.md like the rig's
microcontroller, while a scripted hand holds the pendulum and lets it go. Its physics and its script come from a YAML
file (config/emulated_rig.yaml shows every key); without one it is the paper's pendulum, let go once.

With a --speed other than 1, the rig's time is published on /clock: start the other nodes with use_sim_time:=true."""

EXAMPLE = """\
example:
  ros2 run cdp_ident emulator --link /tmp/rig --rig config/emulated_rig.yaml
  ros2 run cdp_ident driver --ros-args -p port:=/tmp/rig"""


class Emulator:
    """The emulation on its node, in a thread of its own."""

    exit_code: int | None = None

    def __init__(self, node: Any, emulation: Emulation) -> None:
        self._emulation = emulation
        if emulation.speed != 1.0:
            self._clock = node.create_publisher(Clock, "/clock", 10)
            self._start = time.time()
            emulation.on_tick = self._publish_time
        self._complain = node.get_logger().error
        node.get_logger().info(f"the rig is at {shown(emulation.link)}")
        self._thread = threading.Thread(target=self._run, name="emulation", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Unplug the rig."""
        self._emulation.stop()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        code = 1
        try:
            self._emulation.run()
            code = 0
        except CdpIdentError as error:
            self._complain(shown(error))
            code = error.exit_code
        finally:
            self.exit_code = code

    def _publish_time(self, now: float) -> None:
        self._clock.publish(Clock(clock=rclpy.time.Time(seconds=self._start + now).to_msg()))


@entry_point
def main(arguments: list[str]) -> int:
    """Run the emulator."""
    options = parse_arguments(_parser(), arguments)
    rig = load_rig(options.rig) if options.rig else EmulatedRig()

    def make(node: Any, _parameters: Parameters) -> Emulator:
        codec, generator = CODECS[options.codec](), np.random.default_rng(options.seed)
        faults, events = made_of(options, Faults), made_of(options, Events)
        # It may compile for a while: by now signals are only noted, and none is lost in compiled code's callbacks.
        return Emulator(node, Emulation(rig, options.link, codec, generator, faults, events, options.speed))

    return run_node("emulator", make, arguments)


def _parser() -> ArgumentParser:
    parser = ArgumentParser("emulator", DESCRIPTION, EXAMPLE)
    parser.add_argument("--link", type=Path, required=True, help="name of the serial port")
    parser.add_argument("--rig", type=Path, help="YAML file with physics, encoders and script")
    parser.add_argument("--codec", choices=tuple(CODECS), default="binary", help="how frames are written")
    parser.add_argument("--speed", type=within(1e-3, 1000.0), default=1.0, help="the rig's time against the wall's (1)")
    parser.add_argument("--seed", type=within(0, 2**32 - 1, int), default=0, help="of noise and faults (0)")
    group = parser.add_argument_group("faults and events (none by default)")
    for kind in (Faults, Events):
        _add_fields(group, kind)
    return parser


def _add_fields(group: argparse._ArgumentGroup, kind: type[Faults | Events]) -> None:
    """Add an option for each field of a dataclass: the words beneath it are its help, `Limits` limit it."""
    words, limits = field_documentation(kind), limits_of(kind)
    for field in fields(kind):
        least, most, _ = limits[field.name]
        number = int if isinstance(field.default, int) else float
        group.add_argument(
            f"--{field.name.replace('_', '-')}",
            type=Path if least is None or most is None else within(least, most, number),
            nargs="+" if field.default == () else None,
            default=field.default,
            help=words[field.name],
        )
