# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fitted model beside what was measured, as two rigs in one scene: simulator, their descriptions, and viewers.

ros2 launch cdp_ident view.launch.py bag:=bags/swing_wide fitted:=identification/swing_wide/fitted.yaml
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.ros_adapters import get_ros_node

from cdp_ident.configuration.fitted_model import fitted_model, read_fitted_model
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.ros.launching import common_arguments, given, needs, node, value
from cdp_ident.ros.robot_description import describe, keep_described

SHARE = Path(get_package_share_directory("cdp_ident"))
XACRO = SHARE / "urdf/cart_double_pendulum.urdf.xacro"

SIMULATED = {"colour": "0.85 0.4 0.1", "alpha": "0.45"}
"""How the simulated rig differs from the measured one in the scene, beside its place."""

VIEWERS = {"rviz": "rviz2", "plotjuggler": "plotjuggler_ros", "foxglove": "foxglove_bridge"}
"""The package that each viewer needs; that of PlotJuggler brings PlotJuggler itself."""


def generate_launch_description() -> LaunchDescription:
    """Return what is launched."""

    def viewer(name: str, package: str, *arguments: str) -> Node:
        return Node(
            package=package,
            executable=package,
            namespace=LaunchConfiguration("namespace"),
            arguments=arguments,
            parameters=[{"use_sim_time": LaunchConfiguration("use_sim_time")}],
            condition=_chosen(name),
        )

    return LaunchDescription(
        [
            *common_arguments(),
            DeclareLaunchArgument("bag", default_value="", description="replay the trial of this bag"),
            DeclareLaunchArgument(
                "mode",
                default_value="",
                description="replay, free or shadow (beside the live rig); if not given: replay of a bag, else free",
            ),
            DeclareLaunchArgument(
                "fitted", default_value="", description="fitted.yaml: the model, and what the rigs look like"
            ),
            DeclareLaunchArgument(
                "source",
                default_value="",
                description="take the model from this node, such as identify; a fitted.yaml is then for the look only",
            ),
            DeclareLaunchArgument(
                "simulator_parameters",
                default_value="",
                description="ROS parameter file of the simulator, as for joints that mean something else",
            ),
            DeclareLaunchArgument("rate", default_value="", description="the motion's time against the clock's"),
            DeclareLaunchArgument("loop", default_value="", description="whether to begin anew at the trial's end"),
            DeclareLaunchArgument(
                "apart", default_value="0.3", description="from the measured rig to the simulated one behind it [m]"
            ),
            DeclareLaunchArgument("rviz", default_value="true", description="open RViz"),
            DeclareLaunchArgument("plotjuggler", default_value="false", description="open PlotJuggler"),
            DeclareLaunchArgument("foxglove", default_value="false", description="start the bridge to Foxglove"),
            needs("robot_state_publisher", "xacro"),
            *(needs(package, condition=_chosen(name)) for name, package in VIEWERS.items()),
            OpaqueFunction(function=_rigs),
            viewer("rviz", "rviz2", "-d", str(SHARE / "config/view.rviz")),
            viewer("plotjuggler", "plotjuggler", "--layout", str(SHARE / "config/plotjuggler.xml")),
            viewer("foxglove", "foxglove_bridge"),
        ]
    )


def _chosen(viewer: str) -> IfCondition:
    return IfCondition(LaunchConfiguration(viewer))


def _rigs(context: LaunchContext) -> list[Node]:
    namespace, bag, fitted, source = (value(context, name) for name in ("namespace", "bag", "fitted", "source"))
    namespace = f"/{namespace.strip('/')}".rstrip("/")
    mode = value(context, "mode") or ("replay" if bag else "free")
    model = read_fitted_model(Path(fitted), "simulator") if fitted else fitted_model(NOMINAL, "the nominal values")
    described = {}
    time = given(context, use_sim_time=bool)

    def rig(name: str, looks_besides: dict[str, str], remappings: dict[str, str]) -> Node:
        # /tf is one for all rigs: its frames begin with the namespace.
        prefix = f"{namespace}/{name}/".lstrip("/")
        looks = looks_besides | {"prefix": prefix}
        described[f"{namespace}/{name}/robot_state_publisher"] = looks
        text = ParameterValue(describe(XACRO, model, looks), value_type=str)
        return node(
            "robot_state_publisher",
            package="robot_state_publisher",
            namespace=f"{namespace}/{name}",
            parameters=[{"robot_description": text, "publish_frequency": 60.0} | time],
            remappings=remappings.items(),
        )

    file = value(context, "simulator_parameters")
    simulator = node(
        "simulator",
        arguments=[
            *(("--bag", bag) if bag else ()),
            *(("--fitted", fitted) if fitted and not source else ()),
        ],
        parameters=[
            *([file] if file else ()),
            {"mode": mode} | given(context, source=str, rate=float, loop=bool) | time,
        ],
    )
    rigs = [rig("simulated", SIMULATED | {"y": value(context, "apart")}, {})]
    if mode != "free":
        # Only a replay has measured joint states of its own; a live rig has its driver's.
        rigs.append(rig("measured", {}, {"joint_states": f"{namespace}/joint_states"} if mode == "shadow" else {}))
    keep_described(get_ros_node(context), f"{namespace}/simulator", XACRO, described)
    return [*rigs, simulator]
