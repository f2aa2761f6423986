# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""robot_state_publishers are given the model that a node serves, whenever it serves another."""

import time
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import rclpy
import rclpy.executors

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.ros.robot_description import describe, keep_described
from reference.pendulum import TABLE_5

XACRO = Path(__file__).parents[2] / "urdf/cart_double_pendulum.urdf.xacro"
RIG = "/measured/robot_state_publisher"
PATIENCE = 60.0


@pytest.fixture
def executor():
    context = rclpy.Context()
    rclpy.init(context=context)
    yield rclpy.executors.SingleThreadedExecutor(context=context)
    rclpy.shutdown(context=context)


def test_a_description_has_the_model_s_values_and_dry_friction():
    values = TABLE_5 | {"effects.coulomb_friction.outer.torque": 0.002}
    robot = ET.fromstring(describe(XACRO, fitted_model(values, "here"), {"prefix": "rig/"}))
    (outer,) = (joint for joint in robot.iter("joint") if joint.get("name") == "outer_joint")
    assert outer.find("dynamics").attrib == {"damping": repr(TABLE_5["c2"]), "friction": "0.002"}
    assert outer.find("child").get("link") == "rig/outer_rod"


def test_a_publisher_is_given_each_model_that_the_source_comes_to_serve(executor):
    context = executor.context
    source, rig, follower = nodes = [
        rclpy.create_node("simulator", context=context),
        rclpy.create_node("robot_state_publisher", context=context, namespace="/measured"),
        rclpy.create_node("launch", context=context),
    ]
    rig.declare_parameter("robot_description", "none yet")
    keep_described(follower, "/simulator", XACRO, {RIG: {"prefix": "measured/"}})
    for node in nodes:
        executor.add_node(node)
    source.declare_parameters("", list(NOMINAL.items()))
    for values in (NOMINAL, TABLE_5):
        source.set_parameters([rclpy.Parameter(name, value=value) for name, value in values.items()])
        expected = describe(XACRO, fitted_model(values, "here"), {"prefix": "measured/"})
        deadline = time.monotonic() + PATIENCE
        while rig.get_parameter("robot_description").value != expected:
            assert time.monotonic() < deadline
            executor.spin_once(timeout_sec=0.05)
