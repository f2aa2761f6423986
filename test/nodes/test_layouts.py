# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The layouts of RViz, Foxglove and PlotJuggler show what the nodes publish: they are held against running nodes."""

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml
from sensor_msgs.msg import JointState

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / "config"
DESCRIPTIONS = {"/measured/robot_description", "/simulated/robot_description"}
"""Topics of the two robot_state_publishers that view.launch.py starts."""


def foxglove():
    return json.loads((CONFIG / "foxglove.json").read_text())


def foxglove_panels(node):
    """Return the panels that a layout's tree of splits shows."""
    return [node] if isinstance(node, str) else [*foxglove_panels(node["first"]), *foxglove_panels(node["second"])]


def foxglove_positions():
    """Return topic and index of each curve."""
    curves = (path["value"] for panel in foxglove()["configById"].values() for path in panel.get("paths", ()))
    return [
        (topic, int(index)) for topic, index in (re.fullmatch(r"(.+)\.position\[(\d)\]", c).groups() for c in curves)
    ]


def plotjuggler_positions():
    """Return topic and joint of each curve."""
    curves = (curve.get("name") for curve in ET.parse(CONFIG / "plotjuggler.xml").iter("curve"))
    return [re.fullmatch(r"(.+)/(\w+_joint)/position", curve).groups() for curve in curves]


def rviz_models():
    """Return the RobotModel displays by the topic of their description."""
    displays = yaml.safe_load((CONFIG / "view.rviz").read_text())["Visualization Manager"]["Displays"]
    models = [display for display in displays if display["Class"] == "rviz_default_plugins/RobotModel"]
    # Relative, for an RViz in a namespace.
    return {"/" + model["Description Topic"]["Value"]: model for model in models}


@pytest.fixture
def heard(listener, start, start_driver, start_emulator):
    """The latest message of each topic with joint states, while a trial is replayed and a rig is read."""
    messages = {}

    def hear(topic):
        listener.node.create_subscription(JointState, topic, lambda message: messages.update({topic: message}), 10)

    topics = {topic for topic, _ in (*foxglove_positions(), *plotjuggler_positions())}
    for topic in topics:
        hear(topic)
    start("simulator", "--bag", str(ROOT / "bags/swing_check"))
    start_driver()
    start_emulator()
    listener.wait_for(lambda: messages.keys() == topics)
    return messages


def test_every_curve_is_a_position_that_the_nodes_publish(heard, listener):
    named = [(topic, list(heard[topic].name)[index]) for topic, index in foxglove_positions()]
    assert sorted(named) == sorted(plotjuggler_positions())
    assert all(joint in heard[topic].name for topic, joint in plotjuggler_positions())

    selected = ET.parse(CONFIG / "plotjuggler.xml").find(".//selected_topics").get("value").split(";")
    assert set(selected) == heard.keys()

    panels = foxglove()["configById"].values()
    services = {panel["serviceName"] for panel in panels if "serviceName" in panel}
    states = {panel["topicPath"] for panel in panels if "topicPath" in panel}
    listener.wait_for(lambda: services <= dict(listener.node.get_service_names_and_types()).keys())
    assert states <= dict(listener.node.get_topic_names_and_types()).keys()


def test_measured_simulated_and_error_of_both_joints_are_plotted():
    curves = plotjuggler_positions()
    for joint in ("inner_joint", "outer_joint"):
        assert {topic for topic, name in curves if name == joint} == {
            "/measured/joint_states",
            "/joint_states",
            "/simulated/joint_states",
            "/simulated/error",
        }


def test_both_rigs_are_in_the_scenes_also_of_viewers_that_open_late():
    assert rviz_models().keys() == DESCRIPTIONS
    assert all(m["Description Topic"]["Durability Policy"] == "Transient Local" for m in rviz_models().values())
    layers = foxglove()["configById"]["3D!rigs"]["layers"].values()
    assert {layer["topic"] for layer in layers if layer["layerId"] == "foxglove.Urdf"} == DESCRIPTIONS


def test_every_panel_of_foxglove_is_shown():
    layout = foxglove()
    assert sorted(foxglove_panels(layout["layout"])) == sorted(layout["configById"])
