# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""ROS parameter files, read and written without ROS.

`--config FILE` is read here, `--ros-args --params-file FILE` by ROS itself; both mean the same:

    /**/identify:        # in any namespace; or identify, /rig1/identify, /** for any node
      ros__parameters:
        L: 0.4
        nominal: {m1: 0.1}
        nominal.m2: 0.1  # nested or dotted

What `ros2 param dump` writes is such a file, with ROS's own parameters among the names (`is_of_ros`).
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from cdp_ident.errors import NoSectionError, OptionError
from cdp_ident.outside_text import shown
from cdp_ident.user_input import quoted
from cdp_ident.yaml_file import read_yaml

_ROOT = "ros__parameters"
_DEEPEST = 8
QOS_OVERRIDES = "qos_overrides."
"""What the names of the parameters begin with by which ROS lets a user choose a topic's quality of service."""
_OF_ROS = ("use_sim_time", "start_type_description_service")


def is_of_ros(name: str) -> bool:
    """Return whether ROS itself declares a parameter of this name in every node."""
    return name in _OF_ROS or name.startswith(QOS_OVERRIDES)


class ParameterFile(NamedTuple):
    """What a ROS parameter file holds for a node, by dotted name."""

    own: dict[str, Any]
    """Below keys that name the node."""
    for_any: dict[str, Any]
    """Below keys such as `/**`: it may be meant for other nodes."""

    def taken(self, knows: Callable[[str], bool] = lambda name: True) -> dict[str, Any]:
        """Return what the node takes: all that names it, and before that what it knows of the rest; none of ROS's."""
        taken = {name: value for name, value in self.for_any.items() if knows(name)} | self.own
        return {name: value for name, value in taken.items() if not is_of_ros(name)}


def read_parameter_file(path: Path, node: str) -> ParameterFile:
    """Return what a ROS parameter file holds for a node, given by its fully qualified name (`identify`: `/identify`).

    Keys are matched as ROS does: `*` stands for one part of a name, `**` for any number of them, and namespaces may be
    nested. To a bare name, as a command's that has no namespace, the one node of that name is meant, in whichever.

    Raises:
        NoSectionError: none of its keys is for the node.
        OptionError: the file cannot be read, is not YAML, or has several nodes that may be meant.
    """
    try:
        content = read_yaml(path)
    except OSError as error:
        raise OptionError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise OptionError(f"{path} is not YAML: {error}") from error
    full = f"/{node.strip('/')}"
    sections = list(_sections(content, "")) if isinstance(content, dict) else []
    in_namespaces = [key for key, _ in sections if key.endswith(full) and "*" not in key]
    if node != full and in_namespaces and full not in in_namespaces:
        if len(in_namespaces) > 1:
            raise OptionError(f"{path} is for several nodes: {shown(', '.join(in_namespaces))}: keep one of them")
        full = in_namespaces[0]
    if not any(_matches(key, full) for key, _ in sections):
        keys = shown(", ".join(key for key, _ in sections)) or "none"
        raise NoSectionError(
            f"{path} says nothing to {full}: expected a ROS parameter file with a key for it, such as "
            f"'/**/{full.rpartition('/')[2]}: {{{_ROOT}: …}}'; its keys are {shown(keys)}"
        )
    result = ParameterFile({}, {})
    for key, section in sections:
        if _matches(key, full) and section is not None:
            if not isinstance(section, dict) or list(section) != [_ROOT]:
                raise OptionError(
                    f"{path}: below '{key}:' expected '{_ROOT}:' and nothing else, found {quoted(section)}"
                )
            parameters = section[_ROOT]
            if not isinstance(parameters, dict | None):
                raise OptionError(f"{path}: below '{_ROOT}:' expected names and values, found {quoted(parameters)}")
            values = result.for_any if key.rpartition("/")[2].strip("*") == "" else result.own
            values.update(_flat(parameters or {}, "", path))
    return result


def _sections(content: Mapping[Any, Any], namespace: str) -> Iterator[tuple[str, Any]]:
    """Yield the sections for nodes and their keys, with the namespaces that they are nested in."""
    for key, value in content.items():
        name = f"{namespace}/{_name(key).strip('/')}"
        nested = isinstance(value, dict) and value and all(isinstance(below, dict) for below in value.values())
        if nested and _ROOT not in value and name.count("/") < _DEEPEST:
            yield from _sections(value, name)
        else:
            yield name, value


def _matches(key: str, node: str) -> bool:
    parts = {"**": "(?:/[^/]+)*", "*": "/[^/]+"}
    return (
        re.fullmatch("".join(parts.get(part, f"/{re.escape(part)}") for part in key[1:].split("/")), node) is not None
    )


def parameter_file(values: Mapping[str, Any], comments: Iterable[str] = ()) -> str:
    """Return the text of a ROS parameter file with these values for whatever node loads it."""
    head = "".join(f"# {line}\n" for line in comments)
    lines = "".join(f"    {name}: {_scalar(value)}\n" for name, value in values.items())
    return f"{head}/**:\n  {_ROOT}:\n{lines}"


def _scalar(value: Any) -> str:
    return yaml.safe_dump(value, default_flow_style=True, width=10**6, allow_unicode=True).split("\n...")[0].strip()


def _flat(values: Mapping[Any, Any], prefix: str, path: Path) -> Iterable[tuple[str, Any]]:
    if prefix.count(".") > _DEEPEST:
        raise OptionError(f"{path}: {prefix[:60]}… is nested too deep: no parameter's name has so many parts")
    for key, value in values.items():
        name = prefix + _name(key)
        if isinstance(value, dict):
            yield from _flat(value, f"{name}.", path)
        else:
            yield name, value


def _name(key: Any) -> str:
    return key if isinstance(key, str) else quoted(key)
