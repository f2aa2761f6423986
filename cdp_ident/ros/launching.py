# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the launch files share: nodes in a namespace that end together, and packages that must be there before."""

import importlib.util
import os

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import Condition, LaunchContext
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from cdp_ident.bag.metadata import ROS_DISTRO

LEVELS = ("debug", "info", "warn", "error", "fatal")


def common_arguments() -> list[DeclareLaunchArgument]:
    """Return the arguments that every launch file has."""
    return [
        DeclareLaunchArgument("namespace", default_value="", description="namespace of all nodes: one for each rig"),
        DeclareLaunchArgument(
            "log_level", default_value="info", choices=LEVELS, description="from which severity on nodes say something"
        ),
        DeclareLaunchArgument("use_sim_time", default_value="false", description="whether time comes from /clock"),
    ]


def given(context: LaunchContext, **types: type) -> dict[str, ParameterValue]:
    """Return those of the launch arguments that are not empty, as parameters of these types."""
    return {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, kind in types.items()
        if value(context, name)
    }


def value(context: LaunchContext, name: str) -> str:
    """Return what a launch argument is."""
    return str(LaunchConfiguration(name).perform(context))


def node(executable: str, package: str = "cdp_ident", **options: object) -> Node:
    """Return a node without which the others are of no use: when it ends, so does the launch."""

    def end(_event: ProcessExited, context: LaunchContext) -> Shutdown | None:
        # A launch that ends already would tell of each further end as of an error.
        return None if context.is_shutdown else Shutdown(reason=f"{executable} has ended")

    return Node(
        package=package,
        executable=executable,
        **{"namespace": LaunchConfiguration("namespace"), **options},
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
        on_exit=end,
    )


def needs(*packages: str, condition: Condition | None = None) -> OpaqueFunction:
    """Return an action that ends the launch, before anything is started, where one of ROS's packages is missing.

    They are looked for only where the `condition` holds, if there is one.
    """

    def check(_context: LaunchContext) -> None:
        for package in packages:
            if not _is_installed(package):
                apt = f"sudo apt install ros-{os.environ.get('ROS_DISTRO', ROS_DISTRO)}-{package.replace('_', '-')}"
                raise RuntimeError(f"the ROS package {package} is not installed: {apt}")

    return OpaqueFunction(function=check, condition=condition)


def _is_installed(package: str) -> bool:
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        return importlib.util.find_spec(package) is not None
    return True
