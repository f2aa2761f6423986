# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A node's parameters: typed, described, checked, and changed in one piece."""

import math
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import rclpy.exceptions
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.parameter import Parameter

from cdp_ident.configuration.described import Described, described_fields
from cdp_ident.configuration.parameter_file import QOS_OVERRIDES, is_of_ros, read_parameter_file
from cdp_ident.errors import NoSectionError, OptionError
from cdp_ident.user_input import refuse_unknown, user_path

Value = TypeVar("Value", bool, int, float, str, list[str], list[float], list[int])

Options = TypeVar("Options")


class Parameters:
    """The declared parameters of a node: typed, described, and changeable from outside only where that makes sense."""

    def __init__(self, node: Any, of_ros: Sequence[str]) -> None:
        """`of_ros` are ROS's own arguments of the node.

        Of a parameter file without a key for the node a warning tells: one file for a whole robot is the habit.
        Raises `OptionError` where one cannot be read, or a parameter is given without a value (`-p "name:= "`).
        """
        self._node = node
        if empty := [name for name, given in node._parameter_overrides.items() if given.value is None]:
            raise OptionError(f"parameter {empty[0]!r} is given without a value")
        self._will_show: Callable[[str], bool] = lambda name: False
        # Clocks that change while a node runs would mix two times.
        clock = Described("use_sim_time", False, "whether time comes from /clock")
        node.set_descriptor(clock.name, _descriptor(clock))
        self._for_any = _given_to_any(node, of_ros)

    def declare(self, name: str, default: Value, description: str, **more: Any) -> Value:
        """Declare a parameter and return its value: the user's where one was given, else the default.

        `more` are further fields of `Described`. The limits hold for numbers and for each number of a list; `choices`
        for strings. A parameter that is not `changeable` keeps its value while the node runs, but for `show`. Raises
        `OptionError` where the user's value is not allowed.
        """
        described = Described(name, default, description, **more)
        expected = f"expected {described.constraint}: {description}"
        try:
            parameter = self._node.declare_parameter(name, default, _descriptor(described))
        except rclpy.exceptions.InvalidParameterTypeException as error:
            raise OptionError(f"parameter {name!r}: {error}; write it like its default, {default!r}") from error
        except rclpy.exceptions.InvalidParameterValueException as error:
            raise OptionError(f"parameter {name!r}: {error}; {expected}") from error
        value: Value = list(parameter.value) if isinstance(default, list) else parameter.value
        for element in value if isinstance(value, list) else [value]:
            if described.choices and element not in described.choices:
                raise OptionError(f"parameter {name!r} is {element!r}; {expected}")
            if isinstance(element, float | int) and not _inside(element, described):
                raise OptionError(f"parameter {name!r} is {element}; {expected}")
        return value

    def declare_fields(self, defaults: Options, prefix: str = "") -> Options:
        """Declare a parameter for each field of a dataclass, and of those in it; return them with the user's values.

        `described_fields` describes them. Raises `OptionError` as `declare` does.
        """
        described = {of.name: of for of in described_fields(defaults)}
        values: dict[str, Any] = {}
        for field in fields(defaults):  # type: ignore[arg-type]
            name, default = field.name, getattr(defaults, field.name)
            if is_dataclass(default):
                values[name] = self.declare_fields(default, prefix)
                continue
            of, is_path = described[name], isinstance(default, Path)
            value = self.declare(
                prefix + name, str(default) if is_path else default, of.description,
                unit=of.unit, minimum=of.minimum, maximum=of.maximum, choices=of.choices, changeable=of.changeable,
            )  # fmt: skip
            values[name] = user_path(value) if is_path else value
        return replace(defaults, **values)  # type: ignore[type-var]

    def given(self, knows: Callable[[str], bool] = lambda name: True) -> dict[str, Any]:
        """Return what the user gave by `-p` and `--params-file`, by name, declared or not, but for what is ROS's.

        What stands in a file for any node is left out where `knows` is
        false: it is meant for another one.
        """
        overrides = self._node._parameter_overrides  # rclpy has no public way to ask for these
        return {
            name: overrides[name].value
            for name in overrides
            if not is_of_ros(name) and (knows(name) or name not in self._for_any)
        }

    def get(self, name: str) -> Any:
        """Return the present value of a declared parameter."""
        return self._node.get_parameter(name).value

    def show(self, parameters: Iterable[Described], gone: Iterable[str] = ()) -> None:
        """Declare parameters whatever the user gave, set those that are there, and undeclare others.

        All at once and as one event, so that nobody reads old values beside new ones.
        """
        node = self._node
        changed = {
            of.name: (Parameter(of.name, value=of.value), _descriptor(of))
            for of in parameters
            if not node.has_parameter(of.name) or self.get(of.name) != of.value
        }
        for name in gone:  # rclpy undeclares no others
            changed[name] = (Parameter(name), ParameterDescriptor(dynamic_typing=True))
        if changed:
            # The public ways refuse parameters that are read only to others, and declare one at a time.
            descriptors = {name: descriptor for name, (_, descriptor) in changed.items()}
            result = node._set_parameters_atomically_common(
                [parameter for parameter, _ in changed.values()], descriptors
            )
            if not result.successful:
                raise OptionError(result.reason)

    def check_changes(self, check: Callable[[list[Any]], object]) -> None:
        """Refuse a change from outside where `check`, given its parameters, raises `OptionError`, with that reason."""

        def answer(parameters: list[Any]) -> SetParametersResult:
            try:
                check(parameters)
            except OptionError as error:
                return SetParametersResult(successful=False, reason=str(error))
            return SetParametersResult(successful=True)

        self._node.add_on_set_parameters_callback(answer)

    def will_show(self, knows: Callable[[str], bool]) -> None:
        """Let the user give what the node shows once it has it, as `ros2 param dump` writes it; it changes nothing."""
        self._will_show = knows

    def start(self) -> None:
        """End the declarations: refuse what the user gave to this node but nobody declared.

        `run_node` does so before it spins; a body whose work begins while it is made does so before that. Raises
        `OptionError` for an unknown parameter, naming the nearest known one.
        """
        declared = self._node._parameters
        given = [name for name in self.given(declared.__contains__) if not self._will_show(name)]
        refuse_unknown(given, declared, f"parameter of {self._node.get_name()}")
        self.check_changes(_keep_clock)

    def warn_of_idle_overrides(self) -> None:
        """Say which `qos_overrides` given to this node change nothing: it has no such topic."""
        for name in self._node._parameter_overrides:
            if name.startswith(QOS_OVERRIDES) and not self._node.has_parameter(name) and name not in self._for_any:
                self._node.get_logger().warning(
                    f"{name} changes nothing: this node has no such topic, or policy to set"
                )


def _keep_clock(parameters: Iterable[Parameter]) -> None:
    """Refuse to change the clock while the node runs: rclpy, which declares `use_sim_time`, lets anybody do so."""
    if any(parameter.name == "use_sim_time" for parameter in parameters):
        raise OptionError(
            "use_sim_time cannot be changed from outside while the node runs: restart it with the new value"
        )


def _given_to_any(node: Any, of_ros: Sequence[str]) -> set[str]:
    """Return the names of parameters that files give to any node and nothing gives to this one."""
    own: set[str] = set()
    for_any: set[str] = set()
    for option, value in pairwise(of_ros):
        if option == "--params-file":
            try:
                file = read_parameter_file(Path(value), node.get_fully_qualified_name())
            except NoSectionError as error:
                node.get_logger().warning(str(error))
                continue
            own |= file.own.keys()
            for_any |= file.for_any.keys()
        elif option in ("-p", "--param"):
            own.add(value.partition(":=")[0].rpartition(":")[2])
    return for_any - own


def _descriptor(of: Described) -> ParameterDescriptor:
    """Return what ROS's tools tell of a parameter."""
    descriptor = ParameterDescriptor(
        type=Parameter.Type.from_parameter_value(of.value).value,
        description=f"{of.description} [{of.unit}]" if of.unit else of.description,
        additional_constraints=of.constraint,
        read_only=not of.changeable,
    )
    kind = type(of.value)
    if kind in (int, float) and (of.minimum is not None or of.maximum is not None):
        largest = sys.float_info.max if kind is float else 2**63 - 1
        low = -largest if of.minimum is None else kind(of.minimum)
        high = largest if of.maximum is None else kind(of.maximum)
        if kind is float:
            descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high, step=0.0)]
        else:
            descriptor.integer_range = [IntegerRange(from_value=low, to_value=high, step=0)]
    return descriptor


def _inside(value: float, of: Described) -> bool:
    low = -math.inf if of.minimum is None else of.minimum
    high = math.inf if of.maximum is None else of.maximum
    return math.isfinite(value) and low <= value <= high
