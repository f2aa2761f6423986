"""The fitted parameters as ROS has them."""

import copy
import math

import numpy as np
import rclpy
import yaml

from cdp_ident.configuration.fitted_model import read_fitted_model
from cdp_ident.report.fitted import fitted_parameters, fitted_yaml


def test_values_deviations_and_determination_come_under_their_names(content):
    found = {parameter.name: parameter for parameter in fitted_parameters(content)}
    assert found["m1"].value == content["after"]["physical"]["m1"]["value"]
    assert found["std.groups.c1_over_A22"].value == content["after"]["groups"]["c1_over_A22"]["std"]
    assert found["determined.L"].value is True
    assert found["determined.m1"].value is False
    assert found["groups.a1_over_A22"].unit == "1/m"
    assert all(parameter.description for parameter in found.values())


def test_the_file_is_loaded_by_another_node(content, tmp_path):
    (tmp_path / "fitted.yaml").write_text(fitted_yaml(content))
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(tmp_path / "fitted.yaml")], context=context)
    try:
        node = rclpy.create_node("controller", context=context, automatically_declare_parameters_from_overrides=True)
        for parameter in fitted_parameters(content):
            assert node.get_parameter(parameter.name).value == parameter.value
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)


def test_what_no_trial_shows_has_an_infinite_deviation_that_ros_reads(content, tmp_path):
    content = copy.deepcopy(content)
    content["after"]["groups"]["c2_over_A22"]["std"] = math.inf
    text = fitted_yaml(content)
    assert yaml.safe_load(text)["/**"]["ros__parameters"]["std.groups.c2_over_A22"] == math.inf
    (tmp_path / "fitted.yaml").write_text(text)
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(tmp_path / "fitted.yaml")], context=context)
    try:
        node = rclpy.create_node("controller", context=context, automatically_declare_parameters_from_overrides=True)
        assert node.get_parameter("std.groups.c2_over_A22").value == math.inf
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)


def test_a_bag_s_name_cannot_end_the_comment(content):
    content = copy.deepcopy(content)
    content["trials"][0]["name"] = "evil\nm1: 3"
    assert yaml.safe_load(fitted_yaml(content)) == yaml.safe_load(fitted_yaml(content | {"trials": []}))


def test_the_file_is_the_model_that_the_identification_ended_with(outcome, content, tmp_path):
    (tmp_path / "fitted.yaml").write_text(fitted_yaml(content))
    model, after = read_fitted_model(tmp_path / "fitted.yaml", "simulator"), outcome.trace.after
    assert after.model.effects  # there is something in the bags to be found
    assert [active.effect.key for active in model.motion.effects] == [a.effect.key for a in after.model.effects]
    for window in after.fit.windows:
        simulated, _ = model.motion.predict(model.values, window.start, window)
        expected, _ = after.model.predict(after.fit.values, window.start, window)
        np.testing.assert_allclose(simulated, expected, rtol=0, atol=1e-9)


def test_a_second_knock_on_the_same_rod_has_a_name_of_its_own(content):
    content = copy.deepcopy(content)
    (effect,) = content["effects"]
    content["effects"] = [effect, effect]
    names = [parameter.name for parameter in fitted_parameters(content)]
    assert {"effects.coulomb_friction.outer.torque", "effects.coulomb_friction.outer.2.torque"} <= set(names)
    assert len(names) == len(set(names))
