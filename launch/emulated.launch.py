# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rig that is emulated behind a real serial port (a pseudo-terminal), with driver and recorder.

ros2 launch cdp_ident emulated.launch.py rig:=my_rig.yaml options:="--flips 1e-4 --stall-every 5"
"""

import shlex
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import Node

from cdp_ident.ros.launching import common_arguments, node, value

SHARE = Path(get_package_share_directory("cdp_ident"))


def generate_launch_description() -> LaunchDescription:
    """Return what is launched."""
    return LaunchDescription(
        [
            *common_arguments()[:2],
            DeclareLaunchArgument(
                "rig",
                default_value=str(SHARE / "config/emulated_rig.yaml"),
                description="the emulated rig's file: physics, encoders, effects, and what the hand does",
            ),
            DeclareLaunchArgument(
                "link",
                default_value=["/tmp/cdp_ident/", LaunchConfiguration("namespace"), "/port"],
                description="name of its serial port: each rig has its own",
            ),
            DeclareLaunchArgument(
                "speed", default_value="1", description="the rig's time against the wall's; if not 1, /clock tells it"
            ),
            DeclareLaunchArgument(
                "options", default_value="", description="further options of the emulator, such as its faults"
            ),
            DeclareLaunchArgument(
                "rearm", default_value="true", description="whether the recorder waits for each release by itself"
            ),
            IncludeLaunchDescription(
                str(SHARE / "launch/rig.launch.py"),
                launch_arguments={
                    "port": LaunchConfiguration("link"),
                    # Not that of a real rig, which this one would replace.
                    "zero_file": [LaunchConfiguration("link"), "_zero.yaml"],
                    "use_sim_time": PythonExpression([LaunchConfiguration("speed"), " != 1"]),
                }.items(),
            ),
            # The rig comes last: its script begins when it is switched on.
            OpaqueFunction(function=_emulator),
        ]
    )


def _emulator(context: LaunchContext) -> list[Node]:
    options = ("link", "rig", "speed")
    arguments = [word for name in options for word in (f"--{name}", LaunchConfiguration(name))]
    return [node("emulator", arguments=[*arguments, *shlex.split(value(context, "options"))])]
