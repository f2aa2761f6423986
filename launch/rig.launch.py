"""The rig and its trials: driver and recorder.

ros2 launch cdp_ident rig.launch.py port:=/dev/ttyACM0 folder:=trials rearm:=true
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

CONFIG = Path(get_package_share_directory("cdp_ident"), "config")


def generate_launch_description() -> LaunchDescription:
    """Return what is launched."""
    return LaunchDescription(
        [
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
            DeclareLaunchArgument("use_sim_time", default_value="false", description="whether time comes from /clock"),
            OpaqueFunction(function=_nodes),
        ]
    )


def _nodes(context: LaunchContext) -> list[Node]:
    def node(executable: str, **types: type) -> Node:
        given = {
            name: ParameterValue(LaunchConfiguration(name), value_type=kind)
            for name, kind in {"use_sim_time": bool, **types}.items()
            if LaunchConfiguration(name).perform(context)
        }
        return Node(
            package="cdp_ident",
            executable=executable,
            parameters=[LaunchConfiguration("parameters"), given],
            output="screen",
        )

    return [node("driver", port=str, zero_file=str), node("recorder", folder=str, rearm=bool)]
