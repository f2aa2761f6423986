# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Balance a rig upright, as a node: the controller of lqr.py between `joint_states` and `cart_command`.

    python3 $(ros2 pkg prefix --share cdp_ident)/examples/balance.py identification/one/fitted.yaml
    python3 $(ros2 pkg prefix --share cdp_ident)/examples/balance.py          # the model that /identify serves
    python3 $(ros2 pkg prefix --share cdp_ident)/examples/balance.py found/fitted.yaml --follow swing_up.json

Hold both rods upright: as soon as they are still, within `--begin` degrees of it, the controller takes over, so let go
as the cart begins to move. With `--follow` they hang, and are swung up as swing_up.py has planned it. It stops when a
rod or the cart leaves its region, and then waits for rods that are held again. To stop is to send no more commands: the
drive brakes, as it does when this program ends or the line is cut.
"""

import gc
import sys
from argparse import Namespace
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
from lqr import FALLEN, PERIOD, Controller, Design, read_schedule, rods_shown, upright_schedule
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from cdp_ident.command_line import ArgumentParser
from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.errors import CdpIdentError
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.rig.emulator.motion import Drive
from cdp_ident.rig.recording.facts import JointNames, PositionReader
from cdp_ident.ros.model_parameters import ParameterSource
from cdp_ident.ros.node import parse_arguments, run_node
from cdp_ident.ros.parameters import Parameters
from cdp_ident.ros.topics import Subscription

STILL = 0.02
"""Held rods move less than this [rad] …"""
HELD = 60
"""… in so many samples."""
MOST_LOST = 10
"""After more lost samples than this the estimate is too old."""
AT_ONCE = 0.5
"""Samples that arrive within this share of the time in which they were taken were kept by the line, as it keeps them
until the driver opens it. They do not tell that rods are held."""


class Balance:
    """The controller on its node."""

    exit_code: int | None = None

    def __init__(self, node: Any, parameters: Parameters, options: Namespace) -> None:
        self._begin, self._seconds, self._say = np.radians(options.begin), options.seconds, node.get_logger().info
        own = Drive()
        drive = Drive(
            lag=parameters.declare("lag", own.lag, "time constant of the cart's drive", unit="s", minimum=1e-4),
            acceleration=parameters.declare(
                "acceleration", own.acceleration, "the drive's largest", unit="m/s^2", minimum=0.1
            ),
            rail=parameters.declare("rail", 0.9 * own.rail, "it stops beyond this, from the cart's 0", unit="m"),
        )
        self._design = Design(
            1.0 / parameters.declare("rate", 1.0 / PERIOD, "of joint_states", unit="Hz", minimum=1.0),
            drive,
            parameters.declare("delay", 1, "samples until a command acts", minimum=0, maximum=10),
            parameters.declare("friction", True, "whether the controller knows of dry friction"),
        )
        self._follow = read_schedule(options.follow, self._design.period) if options.follow else None
        self._controller: Controller | None = None
        self._source: ParameterSource | None = None
        self._began_ns: int | None = None
        self._last_ns = 0
        self._held: list[np.ndarray] = []
        self._arrived: list[float] = []
        self._farthest = 0.0
        self._reader = PositionReader(JointNames())
        self._commands = node.create_publisher(Float64, "cart_command", QoSProfile(depth=1))
        self._subscription = Subscription(node, JointState, "joint_states", self._take)
        if options.fitted:
            self._take_model(read_parameter_file(options.fitted, "balance").taken(), str(options.fitted))
        else:
            self._source = ParameterSource(node, "/identify", self._take_from_identify)

    def close(self) -> None:
        """Nothing is to be ended: the drive brakes by itself."""

    def _take_model(self, values: dict[str, Any], where: str) -> None:
        fitted = fitted_model(values, where)
        upright, _ = upright_schedule(fitted, self._design)
        self._controller = Controller(self._follow or upright, self._design.drive.acceleration, rods_shown(fitted))
        how = "let the rods hang still" if self._follow else "hold the rods upright"
        self._say(f"{how}: within {np.degrees(self._begin):.1f} degrees the controller takes over")

    def _take_from_identify(self, values: dict[str, Any]) -> None:
        if self._began_ns is not None or not NOMINAL.keys() <= values.keys():
            return  # not under a controller that balances; or it has no result yet
        try:
            self._take_model(values, "/identify")
        except CdpIdentError as error:
            self._say(f"no controller: {error}")

    def _take(self, raw: bytes) -> None:
        position = self._reader.read(raw)
        if position is None or position.cart is None or self._controller is None:
            return
        stamp_ns, measured = (
            position.stamp_ns,
            np.array([position.cart, position.inner, position.inner + position.outer]),
        )
        deviation = self._controller.deviation(measured)
        samples = round((stamp_ns - self._last_ns) * 1e-9 / self._design.period)
        self._last_ns = stamp_ns
        if self._began_ns is None:
            if not self._is_held(deviation):
                return
            self._began_ns, self._farthest, samples = stamp_ns, 0.0, 0
            self._controller.begin(measured)
            self._say("balancing")
        elif why := self._why_not(deviation, samples):
            self._stop(f"stopped after {self._balanced():.2f} s: {why}", 3)
            return
        self._commands.publish(Float64(data=self._controller.command(measured, samples)))
        self._farthest = max(self._farthest, float(np.abs(self._controller.deviation(measured)[1:]).max()))
        if self._balanced() >= self._seconds:
            degrees = np.degrees(self._farthest)
            self._stop(f"balanced for {self._balanced():.1f} s, never farther than {degrees:.1f} degrees", 0)

    def _balanced(self) -> float:
        return (self._last_ns - (self._began_ns or 0)) * 1e-9

    def _is_held(self, deviation: np.ndarray) -> bool:
        self._held = [*self._held[1 - HELD :], deviation[1:]]
        self._arrived = [*self._arrived[1 - HELD :], monotonic()]
        if self._arrived[-1] - self._arrived[0] < AT_ONCE * (HELD - 1) * self._design.period:
            return False
        still = np.ptp(self._held, axis=0).max() < STILL and np.abs(self._held).max() < self._begin
        return bool(still and len(self._held) == HELD and abs(deviation[0]) < self._design.drive.rail)

    def _why_not(self, deviation: np.ndarray, samples: int) -> str:
        if not 0 < samples <= MOST_LOST:
            return "samples are missing"
        if np.abs(deviation[1:]).max() > FALLEN:
            return "the rods fell"
        return "the cart is at the rail's end" if abs(deviation[0]) > self._design.drive.rail else ""

    def _stop(self, words: str, exit_code: int) -> None:
        self._say(words)
        self._began_ns, self._held, self._arrived = None, [], []
        if self._controller:
            self._controller.begin()
        if np.isfinite(self._seconds):
            self.exit_code = exit_code


def main(arguments: list[str]) -> int:
    """Run the controller."""
    parser = ArgumentParser("balance", __doc__ or "", "")
    parser.add_argument(
        "fitted", type=Path, nargs="?", help="fitted.yaml of identify (the model that /identify serves)"
    )
    parser.add_argument("--follow", type=Path, metavar="FILE", help="swing the rods up first: the file of swing_up.py")
    parser.add_argument("--begin", type=float, default=4.0, help="takes over this near to the beginning [degrees] (4)")
    parser.add_argument("--seconds", type=float, default=np.inf, help="ends with 0 after so long, with 3 if it fell")
    options = parse_arguments(parser, arguments)

    def make(node: Any, parameters: Parameters) -> Balance:
        return Balance(node, parameters, options)

    gc.freeze()  # to look through all that was loaded for garbage takes as long as five samples
    try:
        return run_node("balance", make, arguments)
    except CdpIdentError as error:
        print(f"balance: error: {error}", file=sys.stderr)
        return error.exit_code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
