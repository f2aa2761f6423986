"""A rig that is emulated behind a real serial port (a pseudo-terminal), with driver and recorder.

ros2 launch cdp_ident emulated.launch.py rig:=my_rig.yaml options:="--flips 1e-4 --stall-every 5" rearm:=true
"""

import shlex
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.action import Action
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

SHARE = Path(get_package_share_directory("cdp_ident"))


def generate_launch_description() -> LaunchDescription:
    """Return what is launched."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "rig",
                default_value=str(SHARE / "config/emulated_rig.yaml"),
                description="the emulated rig's file: physics, encoders, effects, and what the hand does",
            ),
            DeclareLaunchArgument("link", default_value="/tmp/cdp_ident_rig", description="name of its serial port"),
            DeclareLaunchArgument("speed", default_value="1.0", description="the rig's time against the wall's"),
            DeclareLaunchArgument(
                "options", default_value="", description="further options of the emulator, such as its faults"
            ),
            DeclareLaunchArgument("folder", default_value="", description="where bags go"),
            DeclareLaunchArgument(
                "rearm", default_value="true", description="whether the recorder waits for each release by itself"
            ),
            OpaqueFunction(function=_actions),
        ]
    )


def _actions(context: LaunchContext) -> list[Action]:
    def value(name: str) -> str:
        return str(LaunchConfiguration(name).perform(context))

    emulator = Node(
        package="cdp_ident",
        executable="emulator",
        arguments=[
            *("--link", value("link"), "--rig", value("rig"), "--speed", value("speed")),
            *shlex.split(value("options")),
        ],
        output="screen",
    )
    rig = IncludeLaunchDescription(
        str(SHARE / "launch/rig.launch.py"),
        launch_arguments={
            "port": value("link"),
            # Not that of a real rig, which this one would replace.
            "zero_file": f"{value('link')}_zero.yaml",
            "folder": value("folder"),
            "rearm": value("rearm"),
            "use_sim_time": str(float(value("speed")) != 1.0),
        }.items(),
    )
    # The rig comes last: its script begins when it is switched on.
    return [rig, emulator]
