# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Before any trial, effects are unlikely, and what may be in many places or forms shares their odds."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.tracing.odds import cost, imitated, unlikelihood, unlikelihood_of
from scenarios.swings import MODEL, TRUE, known

DRY = ActiveEffect(known("coulomb_friction.outer"))


def test_an_effect_has_one_in_150(clean):
    assert unlikelihood(DRY, clean.recorded) == pytest.approx(2.0 * math.log(150.0))


def test_what_happens_at_an_instant_may_happen_at_any_node(clean):
    more = unlikelihood(ActiveEffect(known("impulse.inner"), trial=0), clean.recorded) - unlikelihood(
        DRY, clean.recorded
    )
    assert more == pytest.approx(2.0 * math.log(clean.recorded.nodes))


def test_harmonics_of_a_joint_share_the_odds_of_one(clean):
    harmonics = [e for e in known_effects() if e.harmonic and e.joint == "inner"]
    odds = [math.exp(-0.5 * unlikelihood(ActiveEffect(effect), clean.recorded)) for effect in harmonics]
    assert sum(odds) == pytest.approx(len({effect.name for effect in harmonics}) / 150.0)


def test_a_model_s_effects_add_up_and_zeros_of_each_trial_count_as_one(clean):
    one, other = DRY, ActiveEffect(known("joint_spring.outer"))
    both = MODEL.with_effect(one).with_effect(other)
    assert unlikelihood_of(MODEL, clean.recorded) == 0.0
    total = unlikelihood(one, clean.recorded) + unlikelihood(other, clean.recorded)
    assert unlikelihood_of(both, clean.recorded) == pytest.approx(total)
    with_zeros, _ = MODEL.with_zeros(TRUE, [0, 1])
    assert unlikelihood_of(with_zeros, clean.recorded) == pytest.approx(2.0 * math.log(150.0))


def test_where_a_torque_is_missing_an_effect_has_to_explain_more_than_it_would_imitate(clean):
    effect, freedom = replace(clean, model=MODEL.with_effect(DRY)), np.array([100.0, 300.0])
    odds = 2.0 * math.log(150.0)
    assert cost(effect, clean) == pytest.approx(odds) == pytest.approx(-cost(clean, effect))
    missing = replace(effect, is_missing=np.array([False, True]), freedom=freedom)
    assert imitated(missing) == pytest.approx(30.0)
    assert cost(missing, clean) == pytest.approx(odds + 30.0) == pytest.approx(-cost(clean, missing))
    # Of models with as many effects none has more to explain, and a curve counts as two.
    assert cost(missing, effect) == pytest.approx(0.0)
    curve = replace(missing, model=MODEL.with_effect(ActiveEffect(known("unknown_torque.outer.over_angle"))))
    assert cost(curve, missing) == pytest.approx(odds + 30.0)
