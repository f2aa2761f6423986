# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The rig and its trials: driver and recorder.

ros2 launch cdp_ident rig.launch.py port:=/dev/ttyACM0 folder:=trials rearm:=true
ros2 launch cdp_ident rig.launch.py namespace:=rig2 port:=/dev/ttyACM1 folder:=trials/rig2
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from cdp_ident.ros.launching import common_arguments, given, node

CONFIG = Path(get_package_share_directory("cdp_ident"), "config")


def generate_launch_description() -> LaunchDescription:
    """Return what is launched."""
    return LaunchDescription(
        [
            *common_arguments(),
            DeclareLaunchArgument(
                "parameters",
                default_value=str(CONFIG / "rig.yaml"),
                description="ROS parameter file of driver and recorder; what is given below wins over it",
            ),
            DeclareLaunchArgument("port", default_value="", description="serial port, or a pattern"),
            DeclareLaunchArgument("zero_file", default_value="", description="where the hanging position is kept"),
            DeclareLaunchArgument("folder", default_value="", description="where bags go"),
            DeclareLaunchArgument(
                "rearm",
                default_value="",
                description="whether the recorder waits for a release from the start and after each trial by itself",
            ),
            OpaqueFunction(function=_nodes),
        ]
    )


def _nodes(context: LaunchContext) -> list[Node]:
    file, time = LaunchConfiguration("parameters"), {"use_sim_time": bool}
    return [
        node("driver", parameters=[file, given(context, port=str, zero_file=str, **time)]),
        node("recorder", parameters=[file, given(context, folder=str, rearm=bool, **time)]),
    ]
