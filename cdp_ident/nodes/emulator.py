"""Behaves like a rig on a serial port: for demonstrations, tests, and work without the rig."""

import argparse
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import rclpy.time
from rosgraph_msgs.msg import Clock

from cdp_ident.command_line import ArgumentParser, entry_point, within
from cdp_ident.errors import CdpIdentError
from cdp_ident.outside_text import shown
from cdp_ident.rig.codec import CODECS
from cdp_ident.rig.emulator.configuration import EmulatedRig, load_rig
from cdp_ident.rig.emulator.emulation import Emulation, Events
from cdp_ident.rig.emulator.faults import Faults
from cdp_ident.ros.node import parse_arguments, run_node
from cdp_ident.ros.parameters import Parameters

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
        # It may compile for a while: by now signals are only noted, and none is lost in compiled code's callbacks.
        return Emulator(node, _emulation(rig, options))

    return run_node("emulator", make, arguments)


def _emulation(rig: EmulatedRig, options: argparse.Namespace) -> Emulation:
    return Emulation(
        rig,
        options.link,
        CODECS[options.codec](),
        np.random.default_rng(options.seed),
        Faults(options.flips, options.losses, options.bursts, options.delay, options.stall_every, options.stall_for),
        Events(
            options.reset_at,
            options.unplug_at,
            options.unplugged_for,
            options.replug_as,
            options.first_count,
            options.first_time,
        ),
        options.speed,
    )


def _parser() -> ArgumentParser:
    parser = ArgumentParser("emulator", DESCRIPTION, EXAMPLE)
    parser.add_argument("--link", type=Path, required=True, help="name of the serial port")
    parser.add_argument("--rig", type=Path, help="YAML file with physics, encoders and script")
    parser.add_argument("--codec", choices=tuple(CODECS), default="binary", help="how frames are written")
    parser.add_argument("--speed", type=within(1e-3, 1000.0), default=1.0, help="the rig's time against the wall's (1)")
    parser.add_argument("--seed", type=within(0, 2**32 - 1, int), default=0, help="of noise and faults (0)")
    probability, seconds = within(0.0, 1.0), within(0.0, 1e9)
    faults = parser.add_argument_group("faults (none by default)")
    faults.add_argument("--flips", type=probability, default=0.0, help="probability of a flipped bit in a byte")
    faults.add_argument("--losses", type=probability, default=0.0, help="probability that a byte is lost")
    faults.add_argument("--bursts", type=seconds, default=0.0, help="bursts of arbitrary bytes in a second")
    faults.add_argument("--delay", type=seconds, default=0.0, help="batches come up to this late [s]")
    faults.add_argument("--stall-every", type=seconds, default=0.0, help="time from stall to stall [s]")
    faults.add_argument("--stall-for", type=seconds, default=0.5, help="length of a stall [s]")
    faults.add_argument("--reset-at", type=seconds, nargs="+", default=[], help="the device is reset [s]")
    faults.add_argument("--unplug-at", type=seconds, nargs="+", default=[], help="the cable is unplugged [s]")
    faults.add_argument("--unplugged-for", type=seconds, default=2.0, help="until it is plugged in again [s]")
    faults.add_argument("--replug-as", type=Path, help="name of the port after that")
    faults.add_argument(
        "--first-count",
        type=within(-(2**31), 2**31 - 1, int),
        default=0,
        help="counters begin here (2147483000: soon roll over)",
    )
    faults.add_argument(
        "--first-time", type=within(0, 2**32 - 1, int), default=0, help="device's clock begins here [us] (4290000000)"
    )
    return parser
