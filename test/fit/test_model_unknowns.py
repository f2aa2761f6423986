# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The numbers that a fit adjusts: their names, limits and places."""

from dataclasses import replace

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.model_unknowns import ModelUnknowns
from cdp_ident.fit.prior import Mechanism, Prior
from cdp_ident.model.parameters import GROUPS
from scenarios.effects import EFFECTS

MODEL = ModelUnknowns(Mechanism.of(Prior()))


def test_unknowns_are_named_in_the_order_of_their_values():
    model = replace(MODEL, length_std=np.inf)
    for key in ("joint_spring.outer", "cogging_torque.inner.3 per turn"):
        model = model.with_effect(ActiveEffect(EFFECTS[key]))
    assert model.names == (
        *(group.symbol for group in GROUPS),
        "L",
        "joint_spring.outer.stiffness",
        "joint_spring.outer.torque",
        "cogging_torque.inner.3 per turn.sine",
        "cogging_torque.inner.3 per turn.cosine",
    )
    assert len(model.limits[0]) == len(model.limits[1]) == len(model.names)
    assert model.names[model.places(1)] == model.names[-2:]


def test_inertias_moments_and_frictions_may_not_be_negative():
    lower, upper = replace(MODEL, length_std=np.inf, gravity_std=np.inf).limits
    assert np.all(lower == 0.0)
    assert np.all(upper == np.inf)


def test_instants_alone_have_a_reach_that_ends():
    slip = MODEL.with_effect(ActiveEffect(EFFECTS["encoder_slip.outer"], trial=0))
    reach = slip.with_effect(ActiveEffect(EFFECTS["joint_spring.outer"])).reach
    place = slip.names.index("encoder_slip.outer.time")
    assert 0.1 < reach[place] < 0.3
    assert np.all(np.delete(reach, place) == np.inf)


def test_two_of_a_kind_have_names_of_their_own():
    impulse = ActiveEffect(EFFECTS["impulse.inner"], trial=0)
    model = MODEL.with_effect(impulse).with_effect(impulse)
    assert model.labels == ("impulse.inner", "impulse.inner.2")
    assert len(set(model.names)) == len(model.names)


def test_without_an_effect_its_unknowns_are_gone():
    model = MODEL.with_effect(ActiveEffect(EFFECTS["gravity_tilt.base"]))
    model = model.with_effect(ActiveEffect(EFFECTS["joint_spring.outer"]))
    less, remain = model.without_effect(0)
    assert less.names == tuple(np.array(model.names)[remain])
    assert less.effects[0].effect.key == "joint_spring.outer"
    assert len(remain) == len(model.names)
