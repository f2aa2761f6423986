# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import pytest

from cdp_ident.bag.csv_titles import Title, may_be_angles, roles, torques


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("theta1 [deg]", "theta1", "deg"),
        ("Winkel 1 (°)", "Winkel 1", "deg"),
        ("theta1/rad", "theta1", "rad"),
        ("time_ms", "time", "ms"),
        ("x in mm", "x", "mm"),
        ("theta_1", "theta_1", ""),
        ("cart_position", "cart_position", ""),
        ("torque [N m]", "torque", ""),
        ("t", "t", ""),
    ],
)
def test_a_title_is_a_name_and_a_unit(text, name, unit):
    assert (Title.of(text).name, Title.of(text).unit) == (name, unit)


@pytest.mark.parametrize(
    ("titles", "found"),
    [
        ("t theta1 theta2", {"time": 0, "inner": 1, "outer": 2}),
        ("Time q0 q1 dq0 dq1", {"time": 0, "inner": 1, "outer": 2}),
        ("time pos1 pos2 vel1 vel2 tau1 tau2", {"time": 0, "inner": 1, "outer": 2}),
        ("theta2_rad theta1_rad time_s", {"time": 2, "inner": 1, "outer": 0}),
        ("stamp cart_position inner_joint outer_joint", {"time": 0, "cart": 1, "inner": 2, "outer": 3}),
        ("theta1 phi1 theta2", {"outer": 2}),
        ("one two three", {}),
        (
            "frame pivot_x pivot_y joint_x joint_y tip_x tip_y",
            {"frame": 0, "pivot_x": 1, "pivot_y": 2, "joint_x": 3, "joint_y": 4, "tip_x": 5, "tip_y": 6},
        ),
        (
            "x0 y0 x1 y1 x2 y2",
            {"pivot_x": 0, "pivot_y": 1, "joint_x": 2, "joint_y": 3, "tip_x": 4, "tip_y": 5},
        ),
    ],
)
def test_titles_tell_what_columns_are(titles, found):
    assert roles([Title.of(text) for text in titles.split()]) == found


@pytest.mark.parametrize(
    ("titles", "angles"),
    [
        ("packet,time_us,angle", [2]),
        ("pwm,time_us,position,angle", [3]),
        ("t,theta,theta_sim", [1]),
        ("t,measured [deg],model [deg]", [1]),
        ("time,tip x,tip y", []),
        ("time,first,second,velocity,motorCurrent", [1, 2]),
        ("stamp,alpha,beta", [1, 2]),
        ("Time,Model Root/Encoder/phi1,Model Root/Encoder/phi2,Model Root/Motor/u", [1, 2]),
        ("t,position [m],angle,speed", [2]),
        ("t,arm [rad],arm2 [rad],arm [rad/s]", [1, 2]),
    ],
)
def test_titles_tell_which_columns_may_be_angles(titles, angles):
    assert may_be_angles([Title.of(text) for text in titles.split(",")]) == angles


def test_torques_of_both_joints_are_found_for_each_kind():
    titles = "time pos1 pos2 tau_con1 tau_con2 tau_meas2 tau_meas1 tau_fric1 inner_command_Nm outer_command_Nm torque"
    assert torques([Title.of(text) for text in titles.split()]) == [(3, 4), (6, 5), (8, 9), (7, None)]
    assert torques([Title.of(f"/joint_states/{joint}_joint/effort") for joint in ("outer", "inner")]) == [(1, 0)]
    assert torques([Title.of(text) for text in ["t", "u1", "motorCurrent2", "pwm"]]) == [(1, None), (None, 2)]
