# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reads the rig's encoders from its serial port, publishes the joints' positions, and forwards commands of the cart."""

import math
import os
import time
from typing import Any

from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import TimeReference
from std_msgs.msg import Float64

from cdp_ident.bag.device_messages import Health, Level, serialize_time_reference
from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.errors import OptionError, RigError
from cdp_ident.rig.joints import Calibration, load_zero, save_zero
from cdp_ident.rig.measurement import MeasurementStream, assess
from cdp_ident.rig.port import PortReader
from cdp_ident.rig.protocol import CODECS, Commands
from cdp_ident.rig.recording.facts import JointNames
from cdp_ident.ros.node import diagnose, parse_arguments, run_node, serve
from cdp_ident.ros.parameters import Parameters
from cdp_ident.ros.topics import QUEUE_DEPTH, JointStatePublisher, create_publisher
from cdp_ident.user_input import user_path

DESCRIPTION = """\
Read the encoders of a cart double pendulum from a serial port (docs/reference/protocol.md) and publish their positions.
Forward commands of the cart's acceleration [m/s^2]; when they stop, so does the cart, whose drive keeps its own limits.

subscribes cart_command (std_msgs/Float64)                 forwarded at once, each as one frame
publishes  joint_states (sensor_msgs/JointState)           stamped with the time of the measurement
           time_reference (sensor_msgs/TimeReference)      the device's own time of it, with the same stamp
           /diagnostics (diagnostic_msgs/DiagnosticArray)  once a second
serves     ~/zero_hanging (std_srvs/Trigger)               takes a second of rest as hanging, and keeps it

The port may be missing at the start, unplugged and plugged in again: it is tried until it works.
`ros2 param describe /driver NAME` describes a parameter; config/rig.yaml lists all."""

EXAMPLE = """\
example:
  ros2 run cdp_ident driver --ros-args -p port:=/dev/ttyACM0 -p codec:=text -p baud:=115200"""


class Driver:
    """The driver on its node."""

    exit_code: int | None = None

    def __init__(self, node: Any, parameters: Parameters) -> None:
        self._node = node
        port = parameters.declare("port", "/dev/ttyACM0", "serial port, or a pattern such as /dev/serial/by-id/usb-*")
        baud = parameters.declare("baud", 460800, "speed of the line", unit="baud", minimum=1200, maximum=12_000_000)
        codec_name = parameters.declare("codec", "binary", "how the rig writes its frames", choices=tuple(CODECS))
        reset_on_open = parameters.declare(
            "reset_on_open", False, "let DTR fall as the port is closed: many boards are reset when it is opened again"
        )
        calibration = parameters.declare_fields(Calibration())
        joints = parameters.declare_fields(JointNames())
        survives = parameters.declare(
            "counters_survive_reset", False, "true for absolute encoders: the zero still holds after a device reset"
        )
        self._zero_file = user_path(
            parameters.declare("zero_file", _default_zero_file(node), "where the hanging position is kept")
        )
        self._stale_after = parameters.declare(
            "stale_after", 0.5, "without a sample for this long the rig is stale", unit="s", minimum=0.01, maximum=60.0
        )
        velocity_model = parameters.declare(
            "velocity_model",
            "",
            "fitted.yaml whose model's Kalman filter estimates velocities; none are sent without it",
        )
        if not joints.inner_joint or not joints.outer_joint:
            raise OptionError("inner_joint and outer_joint need a name: only the cart may be without an encoder")
        parameters.start()

        self._calibration = calibration
        self._first_joint = 0 if joints.cart_joint else 1
        codec = CODECS[codec_name]()
        self._stream = MeasurementStream(
            codec,
            calibration,
            load_zero(self._zero_file),
            survives,
            bool(parameters.get("use_sim_time")),
        )
        names = (joints.cart_joint, joints.inner_joint, joints.outer_joint)[self._first_joint :]
        self._joint_states = JointStatePublisher(node, "joint_states", names)
        self._observer = _observer(velocity_model) if velocity_model else None
        self._time_references = create_publisher(node, TimeReference, "time_reference", QUEUE_DEPTH)
        serve(node, "~/zero_hanging", self._zero_hanging)
        self._source = ""
        self._clock = node.get_clock()
        self._told: tuple[int, str | None] | None = None
        """The level, and the port, that were last assessed."""
        self._before = self._stream.totals()
        self._assessed = time.monotonic()
        logger = node.get_logger()
        self._reader = PortReader(
            port, baud, self._stream.port_was_opened, self._take, logger.info, logger.warning, reset_on_open
        )
        self._commands = Commands(codec, calibration.cart_sign)
        # Of late commands only the newest is worth forwarding, and none is worth repeating.
        newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        node.create_subscription(Float64, "cart_command", self._forward, newest)
        diagnose(node, self._report)
        self._reader.start()

    def close(self) -> None:
        """Close the port, and let everything arrive that was measured."""
        self._reader.stop()
        self._joint_states.finish()

    def _take(self, data: bytes) -> None:
        now_ns = self._clock.now().nanoseconds
        if now_ns == 0:  # with use_sim_time, before the first /clock
            return
        for stamp_ns, device_ns, positions in self._stream.feed(data, now_ns):
            self._time_references.publish(serialize_time_reference(stamp_ns, device_ns, self._source))
            velocities = self._observer.update(stamp_ns, positions) if self._observer else ()
            self._joint_states.publish(positions[self._first_joint :], stamp_ns, velocities[self._first_joint :])

    def _forward(self, command: Any) -> None:
        self._reader.write(self._commands.frame(command.data))

    def _report(self) -> Health:
        if self._reader.failed:
            self.exit_code = 1
        now, instant = self._stream.totals(), time.monotonic()
        silence = (self._clock.now().nanoseconds - now.last_arrival_ns) * 1e-9 if now.last_arrival_ns else math.inf
        port = self._reader.port
        since = instant - self._assessed
        health = assess(self._before, now, since, silence, self._stale_after, port, self._calibration)
        self._before, self._assessed = now, instant
        self._source = health.hardware_id
        told = health.level, port.name
        # That there is no port, its reader tells.
        if told != self._told and port.name and (self._told is not None or health.level in (Level.WARN, Level.ERROR)):
            _log(self._node.get_logger(), health.level, health.message)
        self._told = told
        return health

    def _zero_hanging(self) -> str:
        zero = self._stream.take_zero()
        cart, inner, outer = zero.counts
        taken = f"hanging is at the counts {cart:.1f} (cart), {inner:.1f} (inner), {outer:.1f} (outer)"
        try:
            save_zero(self._zero_file, zero)
        except RigError as error:
            raise RigError(f"{taken}; but {error}") from error
        self._node.get_logger().info(taken)
        return taken


def _observer(fitted: str) -> Any:
    """Return what estimates velocities by a fitted model."""
    # Without one, the driver takes less than half of the memory, and starts as much faster.
    from cdp_ident.configuration.fitted_model import read_fitted_model  # noqa: PLC0415
    from cdp_ident.replay.observer import Observer  # noqa: PLC0415

    return Observer(read_fitted_model(user_path(fitted), "driver"))


def _default_zero_file(node: Any) -> str:
    home = os.environ.get("ROS_HOME") or "~/.ros"
    return f"{home}/cdp_ident/{node.get_fully_qualified_name().strip('/').replace('/', '.')}_zero.yaml"


def _log(logger: Any, level: int, sentence: str) -> None:
    """Say something with the severity of a level; rclpy takes one severity from each line of code."""
    if level == Level.OK:
        logger.info(sentence)
    elif level == Level.ERROR:
        logger.error(sentence)
    else:
        logger.warning(sentence)


@entry_point
def main(arguments: list[str]) -> int:
    """Run the driver."""
    parse_arguments(ArgumentParser("driver", DESCRIPTION, EXAMPLE), arguments)
    return run_node("driver", Driver, arguments)
