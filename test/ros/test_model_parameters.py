# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model as parameters: which of the places that give them wins, and robot_state_publishers that follow."""

import time
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import rclpy
import rclpy.executors

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.ros.model_parameters import own_values
from cdp_ident.ros.robot_description import describe, keep_described
from reference.pendulum import TABLE_5

FITTED = {**dict.fromkeys(NOMINAL, 0.5), "groups.c1_over_A22": 0.1, "effects.air_drag.inner.coefficient": 0.001}


def test_a_fitted_model_s_file_wins_over_the_paper_s_pendulum_and_ros_over_the_file():
    assert own_values({}, {}) == NOMINAL
    own = own_values({"groups.c1_over_A22": 0.2, "rate": 2.0, "std.m1": 0.1}, FITTED)
    assert own == FITTED | {"groups.c1_over_A22": 0.2}


def test_a_physical_value_is_not_overruled_by_groups_that_belong_to_another_one():
    own = own_values({"m1": 0.2}, FITTED)
    assert own["m1"] == 0.2
    assert "groups.c1_over_A22" not in own
    assert own["effects.air_drag.inner.coefficient"] == 0.001


def test_a_whole_fitted_model_given_by_ros_keeps_its_groups():
    assert own_values(FITTED, {}) == FITTED


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
