# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What nodes share: arguments, a life that ends cleanly, steady timers, services of people's tools, and diagnostics."""

import argparse
import contextlib
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

import rclpy
import rclpy.exceptions
import rclpy.executors
import rclpy.logging
import rclpy.signals
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from std_srvs.srv import Trigger

from cdp_ident.bag.device_messages import Health
from cdp_ident.command_line import ArgumentParser, split_arguments
from cdp_ident.errors import CdpIdentError, OptionError
from cdp_ident.files import open_regular
from cdp_ident.outside_text import shown, utf_8
from cdp_ident.ros.parameters import Parameters

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_PLACES_OF_LOGS = {"HOME", "ROS_HOME", "ROS_LOG_DIR"}
_POLL_SECONDS = 0.1
"""How often a spinning node looks whether it was asked to stop [s]."""


class Body(Protocol):
    """What a node does: it lives on the `rclpy` node it was made with."""

    exit_code: int | None
    """None while the node is to go on; a number makes it stop and becomes the process's exit code."""

    def close(self) -> None:
        """Finish the work: called once, after the last callback and before the `rclpy` node is destroyed."""


def parse_arguments(parser: ArgumentParser, arguments: Sequence[str]) -> argparse.Namespace:
    """Parse a node's own arguments; those of ROS, of which the help tells, are `run_node`'s."""
    parser.epilog = (parser.epilog or "") + (
        "\n\nROS's own arguments follow --ros-args: -p NAME:=VALUE, --params-file FILE, -r OLD:=NEW, --log-level LEVEL."
    )
    return parser.parse_args(arguments)


def run_node(name: str, make_body: Callable[[Any, Parameters], Body], arguments: Sequence[str]) -> int:
    """Run a node until SIGINT, SIGTERM or its own end; return the process's exit code.

    `make_body` is given the `rclpy` node and its `Parameters`, declares what it needs and returns the body. All
    callbacks run in the calling thread. A signal is answered within 0.1 s, after the callback that is running;
    more signals during the shutdown change nothing, nor do they until the process ends.
    Raises `OptionError` where ROS cannot make sense of the arguments.
    """
    asked_to_stop = False

    def stop(_number: int, _frame: FrameType | None) -> None:
        nonlocal asked_to_stop
        asked_to_stop = True  # only a flag: a handler can interrupt anything, even itself

    for number in _SIGNALS:
        signal.signal(number, stop)
    rclpy.logging.set_logger_level("rcl", rclpy.logging.LoggingSeverity.FATAL)  # it repeats what is raised
    of_ros = split_arguments(arguments)[1]
    with _refusal():
        for option, file in pairwise(of_ros):
            if option == "--params-file":
                open_regular(Path(file)).close()  # ROS would wait at a pipe for ever
        if not _PLACES_OF_LOGS & os.environ.keys():
            raise OSError("there is no HOME to keep its logs below: set it, or ROS_LOG_DIR")
        rclpy.init(args=["--ros-args", *of_ros], signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    try:
        with _refusal():
            node = rclpy.create_node(name)
        try:
            parameters = Parameters(node, of_ros)
            body = make_body(node, parameters)
            try:
                parameters.start()
                parameters.warn_of_idle_overrides()
                executor = rclpy.executors.SingleThreadedExecutor()
                executor.add_node(node)
                while not asked_to_stop and body.exit_code is None:
                    executor.spin_once(timeout_sec=_POLL_SECONDS)
                executor.shutdown()
            finally:
                body.close()
        finally:
            node.destroy_node()
    except rclpy.exceptions.NameValidationException as error:
        raise OptionError(f"ROS takes no such name: {error}") from error
    finally:
        rclpy.try_shutdown()
        for number in _SIGNALS:
            signal.signal(number, signal.SIG_IGN)  # else Python, as it ends, gives them back their power to kill
    return body.exit_code or 0


@contextlib.contextmanager
def _refusal() -> Iterator[None]:
    """Turn what ROS raises about arguments and surroundings into an `OptionError`."""
    try:
        yield
    except (RuntimeError, OSError, UnicodeEncodeError, rclpy.exceptions.ParameterException) as error:
        raise OptionError(f"ROS cannot start with these arguments and surroundings: {error}") from error


def call_every(node: Any, seconds: float, action: Callable[[], None]) -> None:
    """Call `action` every so many seconds of a steady clock.

    A node's own timers live in ROS's time, which may be set back and, under `use_sim_time`
    without a clock, stands still.
    """
    node.create_timer(seconds, action, clock=Clock(clock_type=ClockType.STEADY_TIME))


def serve(node: Any, name: str, action: Callable[[], object]) -> None:
    """Serve `name`: the answer is what `action` returns, or no success with what it raises, which is logged too."""

    def answer(_request: Any, response: Any) -> Any:
        try:
            response.success, response.message = True, utf_8(action())
        except CdpIdentError as error:
            response.success, response.message = False, shown(error)
            node.get_logger().warning(response.message)
        return response

    node.create_service(Trigger, name, answer)


def diagnose(node: Any, report: Callable[[], Health]) -> None:
    """Publish what `report` tells, which is asked once a second, under the node's fully qualified name."""
    publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def publish() -> None:
        reported = report()
        status = DiagnosticStatus(
            level=bytes([reported.level]),
            name=node.get_fully_qualified_name(),
            message=utf_8(reported.message),
            hardware_id=utf_8(reported.hardware_id),
            values=[KeyValue(key=key, value=utf_8(value)) for key, value in reported.values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)

    call_every(node, 1.0, publish)
