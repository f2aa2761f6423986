"""ROS parameter files, read and written without ROS.

`--config FILE` is read here, `--ros-args --params-file FILE` by ROS itself; both mean the same:

    identify:            # or /identify, or /** for any node
      ros__parameters:
        L: 0.4
        nominal: {m1: 0.1}
        nominal.m2: 0.1  # nested or dotted
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from cdp_ident.errors import OptionError
from cdp_ident.user_input import quoted
from cdp_ident.yaml_file import read_yaml

_ROOT = "ros__parameters"
_DEEPEST = 8


def read_parameter_file(path: Path, node: str) -> dict[str, Any]:
    """Return what a ROS parameter file holds for a node, by dotted name; the node's own section wins over `/**`.

    Raises:
        OptionError: the file cannot be read, is not YAML, or has no section for the node.
    """
    try:
        content = read_yaml(path)
    except OSError as error:
        raise OptionError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise OptionError(f"{path} is not YAML: {error}") from error
    names = ("/**", "/*", f"/{node}", node)
    if not isinstance(content, dict) or not any(name in content for name in names):
        raise OptionError(f"{path} says nothing to {node}: expected a ROS parameter file, '{node}: {{{_ROOT}: …}}'")
    values: dict[str, Any] = {}
    for name in names:
        section = content.get(name)
        if section is None:
            continue
        if not isinstance(section, dict) or list(section) != [_ROOT]:
            raise OptionError(f"{path}: below '{name}:' expected '{_ROOT}:' and nothing else, found {quoted(section)}")
        parameters = section[_ROOT]
        if not isinstance(parameters, dict | None):
            raise OptionError(f"{path}: below '{_ROOT}:' expected names and values, found {quoted(parameters)}")
        values |= dict(_flat(parameters or {}, "", path))
    return values


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
        name = prefix + (key if isinstance(key, str) else quoted(key))
        if isinstance(value, dict):
            yield from _flat(value, f"{name}.", path)
        else:
            yield name, value
