# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an effect is follows from its formulas."""

from dataclasses import replace

import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State

KINDS = [
    # Errors of encoders, and what bends under them, do not move the rods.
    (lambda e: not e.moves,
     {"encoder_offset", "encoder_scale", "encoder_eccentricity", "encoder_slip", "time_offset", "backlash", "rod_flex",
      "encoder_harmonic", "encoder_compliance", "encoder_filter", "oblique_view", "encoder_interpolation"}),
    (lambda e: e.repeats, {"encoder_interpolation"}),
    (lambda e: e.of_both_encoders, {"rod_flex", "oblique_view"}),
    # Dry friction is what has a formula of its size.
    (lambda e: e.dry, {"coulomb_friction", "stribeck_friction", "drifting_friction", "load_friction",
                       "unknown_torque.inner.friction_over_angle", "unknown_torque.outer.friction_over_angle"}),
    (lambda e: e.uses_accelerations,
     {"geared_rotor", "pivot_compliance", "rod_flex", "encoder_compliance", "encoder_filter"}),
    # Torques of a joint's angle alone, and of its angle and speed.
    (lambda e: e.of_angle and not e.harmonic,
     {"joint_spring", "constant_torque", "magnet",
      "unknown_torque.inner.over_angle", "unknown_torque.outer.over_angle"}),
    (lambda e: e.of_joint and e.name in ("quadratic_friction", "air_drag", "load_friction", "impulse", "geared_rotor"),
     {"quadratic_friction"}),
    # States belong to what remembers, swings or has play.
    (lambda e: e.remembers, {"presliding_friction"}),
    (lambda e: e.is_local, {"magnet", "end_stop"}),
    (lambda e: e.swings, {"pivot_compliance.base.oscillating"}),
    (lambda e: e.states and not e.moves, {"backlash", "encoder_filter", "encoder_compliance"}),
    (lambda e: e.brings_states, {"presliding_friction", "pivot_compliance.base.oscillating"}),
    (lambda e: e.states and e.known_at_zero, {"backlash"}),
]  # fmt: skip


@pytest.mark.parametrize(("has", "expected"), KINDS)
def test_what_an_effect_is_is_known_from_its_formulas(has, expected):
    """Each by its name, or by its key where other effects of the name are not all so."""
    found = [effect for effect in CATALOGUE if has(effect)]
    assert {effect.key if effect.key in expected else effect.name for effect in found} == expected


def test_a_law_in_one_line_names_its_states_and_what_its_names_stand_for():
    law = Law(torque="-size*bend*slope", where=(("slope", "1 + angle^2"),), states=(State("bend", "speed"),))
    effect = Effect("mine", "inner", "mine", law, (EffectParameter("size", "N m", 0.0, 1.0, 0.1),), "mine")
    assert effect.formula == "torque = -size*bend*slope; bend' = speed; slope = 1 + angle^2"
    assert (effect.states, effect.remembers, effect.of_joint, effect.of_angle) == (1, True, True, False)
    assert replace(effect, law=Law(reading="size*angle")).moves is False


def test_an_error_over_the_angle_of_another_form_is_not_looked_for_in_a_spectrum():
    """As one that a user writes, whose parameters are others."""
    of_catalogue = next(effect for effect in CATALOGUE if effect.repeats)
    size, times = (
        replace(p, name=name) for p, name in zip(of_catalogue.parameters[1:], ("size", "times"), strict=True)
    )
    own = replace(of_catalogue, law=Law(reading="size*sin(times*angle)"), parameters=(size, times))
    assert not own.repeats
    assert own.has_score
