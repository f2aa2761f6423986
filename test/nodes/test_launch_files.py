# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The launch files, launched for real, where ROS's launch is installed; from PyPI it is not to be had."""

import os
import signal
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

pytest.importorskip("launch_ros", reason="launch and launch_ros are not installed: they come with ROS 2, not from PyPI")

import rclpy.qos
from ament_index_python.packages import PackageNotFoundError, get_package_prefix, get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from cdp_ident.configuration.parameter_file import parameter_file
from reference.pendulum import TABLE_5

ROOT = Path(__file__).parents[2]
FILES = ("rig", "emulated", "view", "loop")
PATIENCE = 300.0
"""Longest wait for anything [s]: the machine may be busy."""
LAUNCH = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription

arguments = [tuple(word.split(":=", 1)) for word in sys.argv[2:]]
service = LaunchService(noninteractive=True)
service.include_launch_description(
    LaunchDescription([IncludeLaunchDescription(sys.argv[1], launch_arguments=arguments)])
)
sys.exit(service.run())
"""
QUICK_RIG = "{script: [{wait: 4.0}, {hold: {theta1: 2.0, theta2: 2.0, within: 0.5}}, {wait: 0.8}, let_go, {wait: 60}]}"


def path_of(name):
    return str(Path(get_package_share_directory("cdp_ident"), "launch", f"{name}.launch.py"))


def needs(package):
    """Skip a test where a package that it launches is missing."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        pytest.skip(f"the ROS package {package} is not installed")


def hear(listener, kind, *topics):
    """Return the latest message of each topic, by topic, as it comes."""
    messages = {}
    latched = kind is String
    durability = rclpy.qos.DurabilityPolicy.TRANSIENT_LOCAL if latched else rclpy.qos.DurabilityPolicy.VOLATILE
    profile = rclpy.qos.QoSProfile(depth=10, durability=durability)
    for topic in topics:

        def take(message, topic=topic):
            messages[topic] = message

        listener.node.create_subscription(kind, topic, take, profile)
    return messages


@pytest.fixture
def launch(tmp_path):
    """Launch files; at the end all is stopped, and what was launched must end cleanly."""
    launched = []

    def launch_one(name, **arguments):
        words = [f"{key}:={value}" for key, value in arguments.items()]
        with (tmp_path / "log").open("w") as log:
            process = subprocess.Popen(
                [sys.executable, "-c", LAUNCH, path_of(name), *words],
                stdout=log,
                stderr=log,
                cwd=ROOT,
                env=os.environ | {"OVERRIDE_LAUNCH_PROCESS_OUTPUT": "screen", "ROS_LOG_DIR": str(tmp_path / "ros")},
            )
        launched.append(process)
        return process

    yield launch_one
    for process in launched:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        said = (tmp_path / "log").read_text()
        died = [line for line in said.splitlines() if "process has died" in line and "/lib/cdp_ident/" in line]
        assert not died, said
        assert "Caught exception in launch" not in said.partition("user interrupted")[2], said


@pytest.mark.parametrize("name", FILES)
def test_every_argument_has_a_description_and_a_default(name):
    description = PythonLaunchDescriptionSource(path_of(name)).get_launch_description(LaunchContext())
    assert isinstance(description, LaunchDescription)
    arguments = description.get_launch_arguments()
    assert arguments
    assert all(argument.default_value is not None for argument in arguments)
    assert all(argument.description != "no description given" for argument in arguments)


def test_the_emulated_rig_is_recorded_when_it_is_let_go(launch, listener, tmp_path):
    (tmp_path / "rig.yaml").write_text(QUICK_RIG)
    launch("emulated", rig=tmp_path / "rig.yaml", link=tmp_path / "port", folder=tmp_path / "trials")
    listener.wait_for(lambda: "recording" in listener.states)
    assert list(listener.joint_states[-1].name) == ["cart_joint", "inner_joint", "outer_joint"]
    assert len(list((tmp_path / "trials").iterdir())) == 1


@pytest.mark.parametrize("namespace", ["", "rig1"])
def test_a_replay_shows_two_rigs_of_its_own_that_look_like_the_fitted_model(launch, listener, tmp_path, namespace):
    needs("robot_state_publisher")
    (tmp_path / "fitted.yaml").write_text(parameter_file(TABLE_5))
    rigs = [f"{namespace}/{name}".lstrip("/") for name in ("measured", "simulated")]
    descriptions = hear(listener, String, *(f"/{rig}/robot_description" for rig in rigs))
    positions = hear(listener, JointState, *(f"/{rig}/joint_states" for rig in rigs))
    swing, model = ROOT / "bags/swing_check", tmp_path / "fitted.yaml"
    launch("view", namespace=namespace, bag=swing, fitted=model, rate="0.5", rviz="false")
    listener.wait_for(lambda: len(descriptions) == len(positions) == 2)
    for rig in rigs:
        links = {link.get("name"): link for link in ET.fromstring(descriptions[f"/{rig}/robot_description"].data)}
        mass = float(links[f"{rig}/inner_rod"].find("inertial/mass").get("value"))
        assert mass == pytest.approx(TABLE_5["m1"] + TABLE_5["m0"])


def test_a_viewer_that_is_not_installed_is_named_before_anything_is_started(launch, tmp_path):
    needs("robot_state_publisher")  # it would be named first
    try:
        get_package_prefix("foxglove_bridge")
        pytest.skip("foxglove_bridge is installed")
    except PackageNotFoundError:
        pass
    assert launch("view", rviz="false", foxglove="true").wait(PATIENCE) != 0
    said = (tmp_path / "log").read_text()
    assert "foxglove_bridge is not installed: sudo apt install" in said
    assert "process started" not in said


def test_two_emulated_rigs_have_ports_of_their_own():
    description = PythonLaunchDescriptionSource(path_of("emulated")).get_launch_description(LaunchContext())
    (link,) = (argument for argument in description.get_launch_arguments() if argument.name == "link")
    ports = set()
    for namespace in ("", "rig1", "rig2"):
        context = LaunchContext()
        context.launch_configurations["namespace"] = namespace
        ports.add(os.path.normpath("".join(part.perform(context) for part in link.default_value)))
    assert len(ports) == 3


@pytest.mark.parametrize(("speed", "simulated"), [("1", "False"), ("0.5", "True")])
def test_all_nodes_of_the_loop_take_the_time_of_a_rig_of_another_speed(speed, simulated):
    description = PythonLaunchDescriptionSource(path_of("loop")).get_launch_description(LaunchContext())
    (time,) = (argument for argument in description.get_launch_arguments() if argument.name == "use_sim_time")
    context = LaunchContext()
    context.launch_configurations["speed"] = speed
    assert "".join(part.perform(context) for part in time.default_value) == simulated


def test_the_whole_loop_shows_the_model_beside_the_rig(launch, listener, tmp_path):
    needs("robot_state_publisher")
    (tmp_path / "rig.yaml").write_text(QUICK_RIG)
    (tmp_path / "fitted.yaml").write_text(parameter_file(TABLE_5))
    descriptions = hear(listener, String, "/measured/robot_description", "/simulated/robot_description")
    shown = hear(listener, JointState, "/simulated/joint_states", "/simulated/error")
    launch(
        "loop",
        fitted=tmp_path / "fitted.yaml",
        rig=tmp_path / "rig.yaml",
        link=tmp_path / "port",
        folder=tmp_path / "trials",
        rviz="false",
    )
    listener.wait_for(lambda: len(descriptions) == len(shown) == 2)
    assert "recording" in listener.states
