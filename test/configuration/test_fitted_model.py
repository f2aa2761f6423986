# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fitted model as named values, written and read."""

import copy
import math

import numpy as np
import pytest
import rclpy
import yaml
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.configuration.fitted_model import (
    describes_model,
    fitted_model,
    fitted_parameters,
    fitted_yaml,
    read_fitted_model,
)
from cdp_ident.errors import OptionError
from cdp_ident.model.effects import own
from cdp_ident.model.effects.catalogue import CATALOGUE, forget_own
from cdp_ident.model.parameters import (
    GROUPS,
    NOMINAL,
    SYMBOLS,
    groups_of,
    inertia_about_cart,
    physical_coefficients,
)

PHYSICAL = np.array([NOMINAL[symbol] for symbol in SYMBOLS])
A22 = float(inertia_about_cart(PHYSICAL, NOMINAL["L"]))
GIVEN_GROUPS = {
    f"groups.{group.symbol}": 1.01 * float(value)
    for group, value in zip(GROUPS, groups_of(PHYSICAL, NOMINAL["L"]), strict=True)
}


@pytest.fixture
def content(content):
    """A report's content that may be changed."""
    return copy.deepcopy(content)


def model_of(values):
    return fitted_model(NOMINAL | values, "here")


def test_physical_values_alone_are_the_model():
    assert model_of({}).coefficients == pytest.approx(physical_coefficients(NOMINAL), rel=1e-15)
    assert model_of({}).physical == NOMINAL


def test_groups_win_over_the_physical_values_that_they_may_not_belong_to():
    model = model_of(GIVEN_GROUPS)
    assert model.values.tolist() == list(GIVEN_GROUPS.values())
    assert model.coefficients.tolist() == [*GIVEN_GROUPS.values(), NOMINAL["L"], NOMINAL["g"]]


def test_dry_friction_is_told_in_physical_units_for_simulators():
    model = model_of({"effects.coulomb_friction.outer.torque": 0.0018, "effects.air_drag.outer.coefficient": 0.01})
    assert (model.dry_friction("inner"), model.dry_friction("outer")) == (0.0, pytest.approx(0.0018, rel=1e-12))


def test_an_effect_of_one_s_own_comes_with_its_definition():
    strength = {"unit": "N m", "limits": [0, 1], "typical": 0.1}
    spring = {"joint": "inner", "torque": "-k*angle^3", "parameters": {"k": strength}}
    given = {own.OWN_EFFECTS: own.as_text({"hardening": spring}), "effects.hardening.inner.k": 0.02}
    try:
        model = model_of(given)
        (active,) = model.motion.effects
    finally:
        forget_own()
    assert active.effect.law.torque == "-k*angle^3"
    assert model.values[-1] == pytest.approx(0.02 / A22)
    with pytest.raises(OptionError, match="hardening"):
        model_of({name: value for name, value in given.items() if name != own.OWN_EFFECTS})


def test_what_is_said_about_the_fit_is_passed_over():
    about = {"std.m1": math.inf, "determined.groups.c1_over_A22": False, "std.effects.air_drag.inner.coefficient": 1.0}
    assert model_of(about).values.tolist() == model_of({}).values.tolist()
    assert not any(map(describes_model, about))


@given(st.sampled_from(CATALOGUE), st.floats(0.0, 1.0))
def test_every_effect_of_the_catalogue_is_read_in_its_physical_unit(effect, share):
    highest = {p.name: min(p.upper, 100.0) for p in effect.parameters}
    values = {p.name: p.lower + share * (highest[p.name] - p.lower) for p in effect.parameters}
    prefix = f"effects.{effect.name}.{effect.joint}."
    physical = {p.name: values[p.name] * A22**p.inertia_power for p in effect.parameters}
    if effect.curve:
        physical = {"coefficients": list(physical.values())}
    given_values = {prefix + name: value for name, value in physical.items()}
    given_values |= {prefix + "variant": effect.variant} if effect.variant else {}
    given_values |= {prefix + "trial": "swing"} if effect.at_an_instant else {}
    model = model_of(given_values)
    (active,) = model.motion.effects
    assert active.effect is effect
    assert active.all_values(model.values[5:]) == pytest.approx(list(values.values()), rel=1e-12)
    assert active.trial == (0 if effect.at_an_instant else None)


def test_what_happened_once_is_in_its_trial_only():
    impulse = {"impulse": 0.01, "time": 3.0, "trial": "one"}
    again = {"impulse": 0.02, "time": 1.0, "trial": "two"}
    names = {f"effects.impulse.inner.{name}": value for name, value in impulse.items()}
    model = model_of(names | {f"effects.impulse.inner.2.{name}": value for name, value in again.items()})
    assert model.trials == ("one", "two")
    for name, strengths in {"one": [0.01], "two": [0.02], "three": [], None: []}.items():
        acting = model.motion.acting(model.values, model.trial(name))
        assert [A22 * strength for _, (strength, _) in acting.each()] == pytest.approx(strengths)


def test_what_one_trial_has_more_acts_in_that_trial_beside_what_all_have():
    names = {"effects.coulomb_friction.outer.torque": 0.004, "effects.coulomb_friction.outer.2.torque": 0.002}
    model = model_of(names | {"effects.coulomb_friction.outer.2.trial": "one"})
    for name, strengths in {"one": [0.004, 0.002], "two": [0.004], None: [0.004]}.items():
        acting = model.motion.acting(model.values, model.trial(name))
        assert [A22 * strength for _, (strength, *_) in acting.each()] == pytest.approx(strengths)


def test_the_outer_rod_is_as_long_as_the_identification_took_it_to_be():
    assert model_of({}).motion.mechanism.outer_length == 0.4
    assert model_of({"outer_rod_length": 0.5}).motion.mechanism.outer_length == 0.5


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"mm1": 1.0}, "'mm1'; did you mean 'm1'?"),
        ({"groups.a1": 1.0}, "did you mean 'groups.a1_over_A22'?"),
        ({"m1": "heavy"}, "here: m1 is 'heavy'"),
        ({"m1": math.nan}, "here: m1 is nan"),
        ({"c1": -0.1}, "here: c1 is -0.1"),
        ({"L": math.inf}, "here: L is inf"),
        ({"L": 1e308}, "here: L is 1e+308"),
        ({"L": 0.0}, "no mechanism"),
        ({"m1": 1e-300, "m2": 1e-310, "m0": 0.0, "J1": 1e-300}, "here: these values describe no pendulum"),
        ({"J1": True}, "here: J1 is True"),
        (dict.fromkeys(("m1", "m2", "m0", "J1"), 0.0), "no mechanism"),
        (dict.fromkeys(("m1", "m2", "m0", "J1"), 0.0) | GIVEN_GROUPS, "inertia about the cart's joint is 0"),
        ({"groups.c1_over_A22": 0.1}, "give all base parameters"),
        (GIVEN_GROUPS | {"groups.A33_over_A22": 1e-6}, "no mechanism"),
        ({"outer_rod_length": 0.0}, "outer_rod_length is 0.0"),
        ({"effects.dry_friction.inner.torque": 0.1}, "'dry_friction'"),
        ({"effects.coulomb_friction.base.torque": 0.1}, "'base'"),
        ({"effects.coulomb_friction.inner.torqe": 0.1}, "did you mean 'torque'?"),
        ({"effects.coulomb_friction.torque": 0.1}, "expected effects.<name>.<joint>.<parameter>"),
        ({"effects.coulomb_friction.inner.torque": -0.1}, "torque is -0.1"),
        ({"effects.coulomb_friction.inner.torque": math.inf}, "torque is inf"),
        ({"effects.joint_spring.outer.stiffness": 0.1}, "torque [N m] is missing"),
        ({"effects.air_drag.outer.coefficient": 0.1, "effects.air_drag.outer.variant": "plates"}, "'plates'"),
        ({"effects.impulse.inner.impulse": 0.1, "effects.impulse.inner.time": 1.0}, "the name of the trial"),
    ],
)
def test_what_is_no_model_is_refused_with_the_reason(values, words):
    with pytest.raises(OptionError, match=r"here") as caught:
        model_of(values)
    assert words in str(caught.value)


def test_a_missing_parameter_is_named():
    with pytest.raises(OptionError, match="here lacks m0, g;"):
        fitted_model({symbol: value for symbol, value in NOMINAL.items() if symbol not in ("m0", "g")}, "here")


def test_a_file_that_is_none_is_refused_with_its_name(tmp_path):
    (tmp_path / "some.yaml").write_text("/**: {ros__parameters: {m1: 0.1}}")
    with pytest.raises(OptionError, match=r"some\.yaml lacks m2, "):
        read_fitted_model(tmp_path / "some.yaml", "simulator")


def test_values_deviations_and_determination_come_under_their_names(content):
    found = {parameter.name: parameter for parameter in fitted_parameters(content)}
    assert found["m1"].value == content["after"]["physical"]["m1"]["value"]
    assert found["std.groups.c1_over_A22"].value == content["after"]["groups"]["c1_over_A22"]["std"]
    assert found["determined.L"].value is True
    assert found["determined.m1"].value is False
    assert found["groups.a1_over_A22"].unit == "1/m"
    assert all(parameter.description for parameter in found.values())


def test_the_file_is_loaded_by_another_node_infinite_deviations_too(content, tmp_path):
    content["after"]["groups"]["c2_over_A22"]["std"] = math.inf  # no trial shows it
    text = fitted_yaml(content)
    assert yaml.safe_load(text)["/**"]["ros__parameters"]["std.groups.c2_over_A22"] == math.inf
    (tmp_path / "fitted.yaml").write_text(text)
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(tmp_path / "fitted.yaml")], context=context)
    try:
        node = rclpy.create_node("controller", context=context, automatically_declare_parameters_from_overrides=True)
        for parameter in fitted_parameters(content):
            assert node.get_parameter(parameter.name).value == parameter.value
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)


def test_a_bag_s_name_cannot_end_the_comment(content):
    content["trials"][0]["name"] = "evil\nm1: 3"
    assert yaml.safe_load(fitted_yaml(content)) == yaml.safe_load(fitted_yaml(content | {"trials": []}))


def test_the_file_is_the_model_that_the_identification_ended_with(outcome, content, tmp_path):
    (tmp_path / "fitted.yaml").write_text(fitted_yaml(content))
    model, after = read_fitted_model(tmp_path / "fitted.yaml", "simulator"), outcome.trace.completed.fit
    assert after.model.effects  # there is something in the bags to be found
    assert [active.effect.key for active in model.motion.effects] == [a.effect.key for a in after.model.effects]
    for window in after.windows:
        simulated = model.motion.predict(model.values, window.start, window)
        expected = after.model.predict(after.values, window.start, window)
        np.testing.assert_allclose(simulated, expected, rtol=0, atol=1e-9)


def test_a_second_impulse_on_the_same_rod_has_a_name_of_its_own(content):
    (effect,) = content["effects"]
    content["effects"] = [effect, effect]
    names = [parameter.name for parameter in fitted_parameters(content)]
    assert {"effects.coulomb_friction.outer.torque", "effects.coulomb_friction.outer.2.torque"} <= set(names)
    assert len(names) == len(set(names))


def test_a_curve_s_coefficients_are_one_list(content):
    torque = [1e-3 * math.sin(k) for k in range(80)]
    curve = {"coefficients": torque, "coefficients_std": [math.inf, *torque[1:]]}
    content["effects"] = [content["effects"][0] | {"name": "unknown_torque", "variant": "over_angle", "curve": curve}]
    given_values = yaml.safe_load(fitted_yaml(content))["/**"]["ros__parameters"]
    assert given_values["effects.unknown_torque.outer.coefficients"] == pytest.approx(torque)
    assert given_values["std.effects.unknown_torque.outer.coefficients"][0] == math.inf
    model = fitted_model(given_values, "here")
    inertia = inertia_about_cart(np.array([model.physical[symbol] for symbol in SYMBOLS]), model.physical["L"])
    assert inertia * model.values[5:] == pytest.approx(torque)


@pytest.mark.parametrize("coefficients", [None, 1.0, "1", [1.0] * 127, [1.0] * 127 + ["x"], [1.0] * 127 + [math.nan]])
def test_a_curve_that_is_none_is_refused(coefficients):
    with pytest.raises(OptionError, match=r"here: unknown_torque: inner: c"):
        model_of({"effects.unknown_torque.inner.coefficients": coefficients})
