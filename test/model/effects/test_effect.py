# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an effect is follows from its formulas."""

from dataclasses import replace

import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State

EFFECTS = {effect.key: effect for effect in CATALOGUE}
ENCODERS = {
    "encoder_offset", "encoder_scale", "encoder_eccentricity", "encoder_slip", "time_offset", "backlash", "rod_flex",
    "encoder_harmonic", "encoder_compliance", "encoder_filter", "oblique_view",
}  # fmt: skip


def names(has):
    return {effect.name for effect in CATALOGUE if has(effect)}


def keys(has):
    return {effect.key for effect in CATALOGUE if has(effect)}


def test_errors_of_encoders_and_what_bends_under_them_do_not_move_the_rods():
    assert names(lambda effect: not effect.moves) == ENCODERS
    assert names(lambda effect: effect.of_both_encoders) == {"rod_flex", "oblique_view"}


def test_dry_friction_is_what_has_a_formula_of_its_size():
    dry = {"coulomb_friction", "stribeck_friction", "drifting_friction", "load_friction"}
    assert names(lambda effect: effect.dry and not effect.curve) == dry
    curves = keys(lambda effect: effect.dry and effect.curve)
    assert curves == {f"unknown_torque.{joint}.friction_over_angle" for joint in ("inner", "outer")}


def test_what_uses_accelerations_is_known_from_its_formulas():
    assert names(lambda effect: effect.uses_accelerations) == {
        "geared_rotor", "pivot_compliance", "rod_flex", "encoder_compliance", "encoder_filter"
    }  # fmt: skip


def test_torques_of_a_joint_s_angle_alone_and_of_its_angle_and_speed():
    of_angle = names(lambda effect: effect.of_angle and not effect.harmonic and not effect.curve)
    assert of_angle == {"joint_spring", "constant_torque"}
    curves = keys(lambda effect: effect.of_angle and effect.curve)
    assert curves == {f"unknown_torque.{joint}.over_angle" for joint in ("inner", "outer")}
    assert "quadratic_friction" in names(lambda effect: effect.of_joint)
    assert not names(lambda effect: effect.of_joint) & {"air_drag", "load_friction", "impulse", "geared_rotor"}


def test_states_belong_to_what_remembers_swings_or_has_play():
    assert names(lambda effect: effect.remembers) == {"presliding_friction"}
    assert keys(lambda effect: effect.swings) == {"pivot_compliance.base.oscillating"}
    assert names(lambda effect: effect.states and not effect.moves) == {
        "backlash", "encoder_filter", "encoder_compliance"
    }  # fmt: skip
    assert names(lambda effect: effect.brings_states) == {"presliding_friction", "pivot_compliance"}
    assert names(lambda effect: effect.states and effect.known_at_zero) == {"backlash"}


def test_a_law_in_one_line_names_its_states_and_what_its_names_stand_for():
    law = Law(torque="-size*bend*slope", where=(("slope", "1 + angle^2"),), states=(State("bend", "speed"),))
    effect = Effect("mine", "inner", "mine", law, (EffectParameter("size", "N m", 0.0, 1.0, 0.1),), "mine")
    assert effect.formula == "torque = -size*bend*slope; bend' = speed; slope = 1 + angle^2"
    assert (effect.states, effect.remembers, effect.of_joint, effect.of_angle) == (1, True, True, False)
    assert replace(effect, law=Law(reading="size*angle")).moves is False


@pytest.mark.parametrize("key", EFFECTS)
def test_every_state_has_a_rate_and_every_fixed_parameter_one_value(key):
    effect = EFFECTS[key]
    assert all(state.name and state.rate for state in effect.law.states)
    assert all(p.typical == p.lower for p in effect.parameters if p.fixed)
