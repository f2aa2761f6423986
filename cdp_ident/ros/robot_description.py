# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The rig's description: made of a model, and given anew to robot_state_publishers when a node serves another model."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient

from cdp_ident.configuration.fitted_model import FittedModel, fitted_model
from cdp_ident.errors import OptionError
from cdp_ident.ros.model_parameters import ParameterSource

_PATIENCE = 5.0
"""How long a robot_state_publisher that starts is waited for [s]."""


def describe(xacro_file: Path, model: FittedModel, looks: Mapping[str, str]) -> str:
    """Return the URDF of a model; `looks` are further arguments of the xacro file, which needs the package xacro."""
    import xacro  # noqa: PLC0415

    values: dict[str, float] = {symbol: value for symbol, value in model.physical.items() if symbol != "g"}
    values |= {f"{joint}_friction": model.dry_friction(joint) for joint in ("inner", "outer")}
    values["outer_rod_length"] = model.motion.mechanism.outer_length
    mappings = {**{name: repr(value) for name, value in values.items()}, **looks}
    return str(xacro.process_file(str(xacro_file), mappings=mappings).toxml())


def keep_described(node: Any, source: str, xacro_file: Path, rigs: Mapping[str, Mapping[str, str]]) -> ParameterSource:
    """Give robot_state_publishers the description of each model that `source`, a node's full name, serves from now on.

    `rigs` are the looks of each by its full name. It publishes what it is given, and its frames follow.
    """
    clients = {name: AsyncParameterClient(node, name) for name in rigs}

    def take(values: Mapping[str, Any]) -> None:
        try:
            model = fitted_model(values, f"the parameters of {source}")
        except OptionError:  # it has none yet
            return
        for name, client in clients.items():
            if client.wait_for_services(timeout_sec=_PATIENCE):
                client.set_parameters([Parameter("robot_description", value=describe(xacro_file, model, rigs[name]))])

    return ParameterSource(node, source, take)
