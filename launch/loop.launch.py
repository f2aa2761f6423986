# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Everything, from arm to overlay: a rig, its recorder, what identify found, and the model that moves beside the rig.

ros2 launch cdp_ident loop.launch.py identify:="--bag bags/swing_wide bags/swing_folded --out /tmp/found"
ros2 launch cdp_ident loop.launch.py emulated:=false port:=/dev/ttyACM0 fitted:=identification/one/fitted.yaml
"""

import shlex
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import IfElseSubstitution, LaunchConfiguration, NotEqualsSubstitution, PythonExpression
from launch_ros.actions import Node

from cdp_ident.demo.recording import RIG
from cdp_ident.ros.launching import common_arguments, given, node, value

LAUNCH = Path(get_package_share_directory("cdp_ident"), "launch")


def generate_launch_description() -> LaunchDescription:
    """Return what is launched."""
    emulated = LaunchConfiguration("emulated")
    identifies = NotEqualsSubstitution(LaunchConfiguration("identify"), "")
    return LaunchDescription(
        [
            *common_arguments()[:2],
            DeclareLaunchArgument("speed", default_value="1", description="the emulated rig's time against the wall's"),
            DeclareLaunchArgument(
                "use_sim_time",
                default_value=PythonExpression([LaunchConfiguration("speed"), " != 1"]),
                description="whether time comes from /clock; an emulated rig of another speed than 1 tells it there",
            ),
            DeclareLaunchArgument("emulated", default_value="true", description="whether the rig is an emulated one"),
            DeclareLaunchArgument(
                "rig", default_value=str(RIG), description="the emulated rig's file: that of the example bags"
            ),
            DeclareLaunchArgument(
                "identify",
                default_value="",
                description="arguments of identify, whose model is then shown; if not given, that of fitted:=…",
            ),
            DeclareLaunchArgument(
                "rearm", default_value="true", description="whether the recorder waits for each release by itself"
            ),
            IncludeLaunchDescription(
                str(LAUNCH / "view.launch.py"),
                launch_arguments={
                    "mode": "shadow",
                    "source": IfElseSubstitution(identifies, if_value="identify", else_value=""),
                }.items(),
            ),
            OpaqueFunction(function=_identify, condition=IfCondition(identifies)),
            IncludeLaunchDescription(str(LAUNCH / "emulated.launch.py"), condition=IfCondition(emulated)),
            IncludeLaunchDescription(str(LAUNCH / "rig.launch.py"), condition=UnlessCondition(emulated)),
        ]
    )


def _identify(context: LaunchContext) -> list[Node]:
    return [
        node(
            "identify",
            arguments=shlex.split(value(context, "identify")),
            parameters=[given(context, use_sim_time=bool)],
        )
    ]
