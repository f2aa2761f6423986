# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The rig's description moves as the model does: MuJoCo reads the URDF and knows nothing of our equations."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import xacro
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.model.acting import outer_rod_length
from cdp_ident.model.parameters import NOMINAL
from reference import pendulum
from reference.pendulum import TABLE_5
from reference.strategies import pendulums, starts

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (requirements-dev.txt)")

XACRO = Path(__file__).parents[2] / "urdf/cart_double_pendulum.urdf.xacro"
JOINTS = ("cart_joint", "inner_joint", "outer_joint")


def description(**arguments):
    """Return the URDF's text for some of the xacro's arguments."""
    return xacro.process_file(str(XACRO), mappings={name: str(value) for name, value in arguments.items()}).toxml()


def physical(values):
    return {symbol: repr(float(values[symbol])) for symbol in NOMINAL if symbol != "g"}


def engine(urdf, gravity=NOMINAL["g"]):
    """Return MuJoCo's model of a URDF, every link a body of its own."""
    root = ET.fromstring(urdf)
    compiler = ET.SubElement(ET.SubElement(root, "mujoco"), "compiler")
    compiler.set("fusestatic", "false")
    compiler.set("discardvisual", "false")
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    model.opt.gravity[:] = 0.0, 0.0, -gravity
    return model


def posed(model, cart, theta1, theta2, omega1=0.0, omega2=0.0):
    data = mujoco.MjData(model)
    data.qpos[:] = cart, theta1, theta2 - theta1
    data.qvel[:] = 0.0, omega1, omega2 - omega1
    mujoco.mj_forward(model, data)
    return data


@given(values=pendulums(), state=starts(speed=15.0), u=st.floats(-10, 10))
def test_the_rods_accelerate_as_the_lagrangian_says(values, state, u):
    model = engine(description(**physical(values)), values["g"])
    data = posed(model, 0.1, *state)
    inertia = np.empty((3, 3))
    mujoco.mj_fullM(model, inertia, data.qM)
    torque = data.qfrc_passive - data.qfrc_bias
    relative = np.linalg.solve(inertia[1:, 1:], torque[1:] - inertia[1:, 0] * u)
    expected = pendulum.accelerations(values, state, u)
    np.testing.assert_allclose(np.cumsum(relative), expected, rtol=1e-7, atol=1e-9 + 1e-7 * np.abs(expected).max())


@pytest.mark.parametrize(("theta1", "theta2"), [(0.0, 0.0), (np.pi, np.pi), (0.5, 0.5), (0.3, -1.2), (3.36, 3.89)])
def test_the_rods_ends_are_where_the_angles_say(theta1, theta2):
    model = engine(description(L=0.4, outer_rod_length=0.35, rail_height=1.5, y=0.25))
    places = posed(model, 0.2, theta1, theta2)
    elbow = np.array([0.2 + 0.4 * np.sin(theta1), 0.25, 1.5 + 0.4 * np.cos(theta1)])
    np.testing.assert_allclose(places.body("outer_rod").xpos, elbow, atol=1e-12)
    tip = elbow + 0.35 * np.array([np.sin(theta2), 0.0, np.cos(theta2)])
    np.testing.assert_allclose(places.body("tip").xpos, tip, atol=1e-12)


def test_the_joints_are_those_of_the_joint_states():
    joints = {joint.get("name"): joint for joint in ET.fromstring(description()).iter("joint")}
    moving = {name: joint for name, joint in joints.items() if joint.get("type") != "fixed"}
    assert tuple(moving) == JOINTS
    assert [joint.get("type") for joint in moving.values()] == ["prismatic", "continuous", "continuous"]
    assert [joint.find("axis").get("xyz") for joint in moving.values()] == ["1 0 0", "0 1 0", "0 1 0"]


def test_by_default_it_is_the_nominal_pendulum():
    given_values = physical(NOMINAL) | {"outer_rod_length": outer_rod_length(NOMINAL["L"], NOMINAL["l2"])}
    assert description() == description(**given_values)


def test_two_rigs_share_the_world_and_nothing_else():
    links = [
        {link.get("name") for link in ET.fromstring(description(prefix=prefix)).iter("link")}
        for prefix in ("measured/", "simulated/")
    ]
    assert set.intersection(*links) == {"world"}


def test_a_body_is_one_that_can_exist_and_can_be_translucent():
    rig = ET.fromstring(description(**physical(TABLE_5), alpha=0.4))
    assert {colour.get("rgba").split()[-1] for colour in rig.iter("color")} == {"0.4"}
    for link in rig.iter("link"):
        if (inertia := link.find("inertial/inertia")) is not None:
            moments = sorted(float(inertia.get(axis)) for axis in ("ixx", "iyy", "izz"))
            assert moments[0] > 0.0
            assert moments[2] <= moments[0] + moments[1]


def test_dry_friction_is_that_of_each_joint():
    model = engine(description(inner_friction=0.003, outer_friction=0.0018))
    assert [model.joint(name).frictionloss[0] for name in JOINTS] == [0.0, 0.003, 0.0018]


def test_a_controller_may_drive_the_cart_and_read_all_joints():
    assert ET.fromstring(description()).find("ros2_control") is None
    control = ET.fromstring(description(controllers="/rig/controllers.yaml")).find("ros2_control")
    joints = {joint.get("name"): [one.tag for one in joint] for joint in control.iter("joint")}
    assert joints == {
        "cart_joint": ["command_interface", "state_interface", "state_interface"],
        "inner_joint": ["state_interface", "state_interface"],
        "outer_joint": ["state_interface", "state_interface"],
    }
