# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A node's parameters: typed, described, checked, and changed in one piece."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import rclpy.exceptions
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.parameter import Parameter

from cdp_ident.configuration.field_documentation import field_documentation, without_unit
from cdp_ident.configuration.parameter_file import QOS_OVERRIDES, is_of_ros, read_parameter_file
from cdp_ident.errors import NoSectionError, OptionError
from cdp_ident.user_input import limits_of, refuse_unknown, user_path

Value = TypeVar("Value", bool, int, float, str, list[str], list[float], list[int])

Options = TypeVar("Options")

_LARGEST = {float: 1.7976931348623157e308, int: 2**63 - 1}


class Shown(NamedTuple):
    """A parameter as others see it."""

    value: Any
    """A number, text, truth value or a list of one of these."""
    description: str
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    choices: Sequence[str] = ()
    changeable: bool = False
    """Whether others may set it; it is read only to them if not."""

    @property
    def constraint(self) -> str:
        """In words, what values are allowed."""
        return (
            f"one of: {', '.join(self.choices)}" if self.choices else _interval(self.minimum, self.maximum, self.unit)
        )

    def descriptor(self) -> ParameterDescriptor:
        """Return its description for ROS's tools."""
        descriptor = ParameterDescriptor(
            type=Parameter.Type.from_parameter_value(self.value).value,
            description=f"{self.description} [{self.unit}]" if self.unit else self.description,
            additional_constraints=self.constraint,
            read_only=not self.changeable,
        )
        limited = self.minimum is not None or self.maximum is not None
        if type(self.value) is float and limited:
            low, high = _limits(float, self.minimum, self.maximum)
            descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high, step=0.0)]
        elif type(self.value) is int and limited:
            low, high = _limits(int, self.minimum, self.maximum)
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=0)]
        return descriptor


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
        node.set_descriptor("use_sim_time", Shown(False, "whether time comes from /clock").descriptor())
        self._for_any = _given_to_any(node, of_ros)

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
    ) -> Value:
        """Declare a parameter and return its value: the user's where one was given, else the default.

        The limits hold for numbers and for each number of a list; `choices` for strings. A parameter that is not
        `changeable` keeps its value while the node runs, but for `set`. Raises `OptionError` where the user's value is
        not allowed.
        """
        shown = Shown(default, description, unit, minimum, maximum, choices, changeable)
        constraint = shown.constraint
        try:
            parameter = self._node.declare_parameter(name, default, shown.descriptor())
        except rclpy.exceptions.InvalidParameterTypeException as error:
            raise OptionError(f"parameter {name!r}: {error}; write it like its default, {default!r}") from error
        except rclpy.exceptions.InvalidParameterValueException as error:
            raise OptionError(f"parameter {name!r}: {error}; expected {constraint}: {description}") from error
        value: Value = list(parameter.value) if isinstance(default, list) else parameter.value
        for element in value if isinstance(value, list) else [value]:
            if choices and element not in choices:
                raise OptionError(f"parameter {name!r} is {element!r}; expected {constraint}: {description}")
            if isinstance(element, float | int) and not _inside(element, minimum, maximum):
                raise OptionError(f"parameter {name!r} is {element}; expected {constraint}: {description}")
        return value

    def declare_fields(self, defaults: Options, prefix: str = "") -> Options:
        """Declare a parameter for each field of a dataclass, and of those in it; return them with the user's values.

        The words beneath a field describe its parameter, and `Limits` in its annotation limit it. Raises `OptionError`
        as `declare` does.
        """
        words, limits = field_documentation(type(defaults)), limits_of(type(defaults))
        values: dict[str, Any] = {}
        for field in fields(defaults):  # type: ignore[arg-type]
            name, default = field.name, getattr(defaults, field.name)
            if is_dataclass(default):
                values[name] = self.declare_fields(default, prefix)
                continue
            text, unit = without_unit(words[name])
            is_path = isinstance(default, Path)
            minimum, maximum, changeable = limits[name]
            value = self.declare(
                prefix + name, str(default) if is_path else default, text,
                unit=unit, minimum=minimum, maximum=maximum, changeable=changeable,
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

    def set(self, values: Mapping[str, Any]) -> None:
        """Set declared parameters from inside the node, changeable or not: all at once, as one event."""
        self._update({name: Parameter(name, value=value) for name, value in values.items()}, {})

    def show(self, parameters: Mapping[str, Shown], gone: Iterable[str] = ()) -> None:
        """Declare parameters whatever the user gave, set those that are there, and undeclare others.

        All at once and as one event, so that nobody reads old values beside new ones.
        """
        descriptors = {name: shown.descriptor() for name, shown in parameters.items()}
        changed = {
            name: Parameter(name, value=shown.value)
            for name, shown in parameters.items()
            if not self._node.has_parameter(name) or self.get(name) != shown.value
        }
        for name in gone:
            changed[name] = Parameter(name)
            descriptors[name] = ParameterDescriptor(dynamic_typing=True)  # rclpy undeclares no others
        self._update(changed, descriptors)

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

    def _update(self, parameters: Mapping[str, Parameter], descriptors: Mapping[str, ParameterDescriptor]) -> None:
        if parameters:
            # The public ways refuse parameters that are read only to others, and declare one at a time.
            own = {name: descriptors.get(name) or self._node._descriptors[name] for name in parameters}
            result = self._node._set_parameters_atomically_common(list(parameters.values()), own)
            if not result.successful:
                raise OptionError(result.reason)


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
