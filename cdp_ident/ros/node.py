"""What every node shares: arguments, declared parameters, and a life that ends cleanly."""

import argparse
import contextlib
import math
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import Any, Protocol, TypeVar

import rclpy
import rclpy.exceptions
import rclpy.executors
import rclpy.logging
import rclpy.signals
import rclpy.utilities
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.parameter import Parameter

from cdp_ident.command_line import ArgumentParser
from cdp_ident.errors import OptionError
from cdp_ident.user_input import refuse_unknown

Value = TypeVar("Value", bool, int, float, str, list[str], list[float], list[int])

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_POLL_SECONDS = 0.1
"""How often a spinning node looks whether it was asked to stop [s]."""
_LARGEST = {float: 1.7976931348623157e308, int: 2**63 - 1}


class Body(Protocol):
    """What a node does: it lives on the `rclpy` node it was made with."""

    exit_code: int | None
    """None while the node is to go on; a number makes it stop and becomes the process's exit code."""

    def close(self) -> None:
        """Finish the work: called once, after the last callback and before the `rclpy` node is destroyed."""


class Parameters:
    """The declared parameters of a node: typed, described, and changeable from outside only where that makes sense."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._changeable: set[str] = set()
        self._advice: dict[str, str] = {}
        self._own_thread: int | None = None
        self._started = False
        node.add_on_set_parameters_callback(self._judge)

    def declare(
        self,
        name: str,
        default: Value,
        description: str,
        *,
        unit: str = "",
        minimum: float | None = None,
        maximum: float | None = None,
        choices: Sequence[str] = (),
        changeable: bool = False,
        overridable: bool = True,
        advice: str = "restart it with the new value",
    ) -> Value:
        """Declare a parameter and return its value: the user's where one was given, else the default.

        The limits hold for numbers and for each number of a list; `choices` for strings. A parameter that is not
        `changeable` keeps its value while the node runs; who tries to change it is given the `advice`. One that is not
        `overridable` has the default whatever the user gave: a result, or what was made of `given()`. Raises
        `OptionError` where the user's value is not allowed.
        """
        self._advice[name] = advice
        constraint = f"one of: {', '.join(choices)}" if choices else _interval(minimum, maximum, unit)
        descriptor = ParameterDescriptor(
            description=f"{description} [{unit}]" if unit else description, additional_constraints=constraint
        )
        if type(default) is float and (minimum is not None or maximum is not None):
            low, high = _limits(float, minimum, maximum)
            descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high, step=0.0)]
        elif type(default) is int and (minimum is not None or maximum is not None):
            low, high = _limits(int, minimum, maximum)
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=0)]
        try:
            with self._from_inside():
                parameter = self._node.declare_parameter(name, default, descriptor, ignore_override=not overridable)
        except rclpy.exceptions.InvalidParameterTypeException as error:
            raise OptionError(f"parameter {name!r}: {error}; write it like its default, {default!r}") from error
        except rclpy.exceptions.InvalidParameterValueException as error:
            raise OptionError(f"parameter {name!r}: {error}; expected {constraint}: {description}") from error
        if changeable:
            self._changeable.add(name)
        if not overridable:
            return default
        value: Value = list(parameter.value) if isinstance(default, list) else parameter.value
        for element in value if isinstance(value, list) else [value]:
            if choices and element not in choices:
                raise OptionError(f"parameter {name!r} is {element!r}; expected {constraint}: {description}")
            if isinstance(element, float | int) and not _inside(element, minimum, maximum):
                raise OptionError(f"parameter {name!r} is {element}; expected {constraint}: {description}")
        return value

    def given(self) -> dict[str, Any]:
        """Return what the user gave by `-p` and `--params-file`, by name, declared or not."""
        overrides = self._node._parameter_overrides  # rclpy has no public way to ask for these
        return {name: overrides[name].value for name in overrides if not name.startswith("qos_overrides.")}

    def get(self, name: str) -> Any:
        """Return the present value of a declared parameter."""
        return self._node.get_parameter(name).value

    def set(self, values: dict[str, Any]) -> None:
        """Set parameters from inside the node, whether or not they are changeable from outside."""
        with self._from_inside():
            results = self._node.set_parameters([Parameter(name, value=value) for name, value in values.items()])
        for result in results:
            if not result.successful:
                raise OptionError(result.reason)

    def start(self, pass_over: tuple[str, ...] = ()) -> None:
        """End the declarations: refuse what the user gave but nobody declared, and outside changes from now on.

        `run_node` does so before it spins; a body whose work begins while it is made does so before that. What begins
        with one of `pass_over` may be given without being declared: a file that says more than the node needs.
        Raises `OptionError` for an unknown parameter, naming the nearest known one.
        """
        if self._started:
            return
        given = [name for name in self.given() if not name.startswith(pass_over)]
        refuse_unknown(given, self._node._parameters, f"parameter of {self._node.get_name()}")
        self._started = True

    @contextlib.contextmanager
    def _from_inside(self) -> Iterator[None]:
        self._own_thread = threading.get_ident()
        try:
            yield
        finally:
            self._own_thread = None

    def _judge(self, parameters: list[Any]) -> Any:
        if not self._started or self._own_thread == threading.get_ident():
            return SetParametersResult(successful=True)
        for parameter in parameters:
            if parameter.name not in self._changeable:
                reason = f"{parameter.name} cannot be changed from outside while {self._node.get_name()} runs"
                return SetParametersResult(successful=False, reason=f"{reason}: {self._advice.get(parameter.name, '')}")
        return SetParametersResult(successful=True)


def parse_arguments(parser: ArgumentParser, arguments: Sequence[str]) -> argparse.Namespace:
    """Parse what is left of a node's arguments without `--ros-args …`, which `run_node` hands to ROS."""
    parser.epilog = (parser.epilog or "") + (
        "\n\nROS's own arguments follow --ros-args: -p NAME:=VALUE, --params-file FILE, -r OLD:=NEW, --log-level LEVEL."
    )
    with _refusal():
        own = rclpy.utilities.remove_ros_args(list(arguments))
    return parser.parse_args(own)


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
    with _refusal():
        rclpy.init(args=list(arguments), signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    try:
        with _refusal():
            node = rclpy.create_node(name)
        try:
            parameters = Parameters(node)
            body = make_body(node, parameters)
            try:
                parameters.start()
                executor = rclpy.executors.SingleThreadedExecutor()
                executor.add_node(node)
                while not asked_to_stop and body.exit_code is None:
                    executor.spin_once(timeout_sec=_POLL_SECONDS)
                executor.shutdown()
            finally:
                body.close()
        finally:
            node.destroy_node()
    finally:
        rclpy.try_shutdown()
        for number in _SIGNALS:
            signal.signal(number, signal.SIG_IGN)  # else Python, as it ends, gives them back their power to kill
    return body.exit_code or 0


@contextlib.contextmanager
def _refusal() -> Iterator[None]:
    """Turn what ROS raises about arguments and names into an `OptionError`."""
    try:
        yield
    except (RuntimeError, rclpy.exceptions.NameValidationException) as error:
        raise OptionError(f"ROS cannot use the arguments after --ros-args: {error}") from error


def _limits(kind: type, minimum: float | None, maximum: float | None) -> tuple[float, float]:
    largest = _LARGEST[kind]
    return (-largest if minimum is None else minimum), (largest if maximum is None else maximum)


def _inside(value: float, minimum: float | None, maximum: float | None) -> bool:
    return math.isfinite(value) and (minimum is None or value >= minimum) and (maximum is None or value <= maximum)


def _interval(minimum: float | None, maximum: float | None, unit: str) -> str:
    if minimum is None and maximum is None:
        return ""
    low = "" if minimum is None else f"at least {minimum:g}"
    high = "" if maximum is None else f"at most {maximum:g}"
    return " and ".join(filter(None, (low, high))) + (f" {unit}" if unit else "")
