# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a model, those are proposed that its scores promise, and that it does not contain already."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.tracing.neighbours import (
    additions,
    at_the_place_of,
    beside_rivals,
    extended_models,
    extended_replacements,
    near_a_place,
    replacements,
    scores_of,
    simplifications,
    strength,
    together,
)
from cdp_ident.tracing.odds import unlikelihood
from scenarios.swings import TIME, fitted, known, measured, motion, recorded, with_effect

DRY = "coulomb_friction.outer"


@pytest.fixture(scope="module")
def scored(rubbing):
    """What each effect that has a name would do."""
    return scores_of(rubbing, named_only=True)


@pytest.fixture(scope="module")
def with_friction(rubbing):
    return with_effect(rubbing, DRY, 5e-3)


@pytest.fixture(scope="module")
def with_curve(rubbing):
    """The model with a curve of no strength, not fitted, and torques missing in both joints."""
    curve = next(e for e in known_effects() if e.curve and e.joint == "outer" and e.curve.over == "angle" and not e.dry)
    model = rubbing.model.with_effect(ActiveEffect(curve, bend=0.01))
    values = np.concatenate([rubbing.values, np.zeros(curve.curve.count)])
    linear = [
        swing.linearised(model, values, of) for swing, of in zip(rubbing.recorded.swings, rubbing.states, strict=True)
    ]
    return replace(rubbing, model=model, values=values, linear=tuple(linear), is_missing=np.array([True, True]))


def test_the_hidden_effect_s_score_is_first_and_so_is_its_model_and_scores_come_once_for_each_the_best_first(
    rubbing, scored
):
    neighbours = list(additions(rubbing, scored))
    assert scored[0].active.effect.key == DRY
    assert neighbours[0].what == (DRY,)
    assert neighbours[0].model.labels == (DRY,)
    np.testing.assert_array_equal(neighbours[0].values, [*rubbing.values, *scored[0].values])
    scored = scores_of(rubbing, named_only=False)
    keys = [(score.active.effect.key, score.active.trial) for score in scored]
    assert len(keys) == len(set(keys))
    costs = [score.misfit + unlikelihood(score.active, rubbing.recorded) for score in scored]
    assert costs == sorted(costs)


def test_nothing_is_proposed_where_nothing_is_hidden(clean):
    scored = scores_of(clean, named_only=False)
    neighbours = list(additions(clean, scored))
    assert neighbours == []
    assert scored


def test_a_curve_has_a_score_only_where_it_may_be_named_a_curve_and_in_a_joint_where_a_torque_is_missing(
    rubbing, scored
):
    assert not any(score.active.effect.curve for score in scored)
    assert rubbing.is_missing.tolist() == [False, True]
    any_torque = scores_of(rubbing, named_only=False)
    neighbours = list(additions(rubbing, any_torque))
    curves = [score for score in any_torque if score.active.effect.curve]
    assert {score.active.effect.joint for score in curves} == {"outer"}
    # Of several torques without a name one is proposed.
    assert len(curves) > 1
    assert sum(neighbour.model.effects[-1].effect.curve is not None for neighbour in neighbours) <= 1


def test_a_curve_over_an_angle_excludes_what_depends_on_its_joint_s_angle_alone(with_curve):
    scored = scores_of(with_curve, named_only=True)
    assert not any(score.active.effect.joint == "outer" and score.active.effect.of_angle for score in scored)
    assert any(score.active.effect.joint == "inner" and score.active.effect.of_angle for score in scored)


def test_a_joint_may_have_several_harmonics(rubbing):
    harmonic = next(e for e in known_effects() if e.harmonic and e.joint == "outer" and e.moves)
    count = len(ActiveEffect(harmonic).fitted)
    found = with_effect(rubbing, harmonic.key, *np.full(count, 1e-3))
    scored = scores_of(found, named_only=True)
    effects = [score.active.effect for score in scored]
    others = [e.key for e in effects if (e.name, e.joint) == (harmonic.name, "outer")]
    assert others
    assert harmonic.key not in others


def test_an_extended_model_begins_with_what_it_contains(with_friction):
    forms = list(extended_models(replace(with_friction, is_missing=np.array([False, True]))))
    assert forms
    for neighbour in forms:
        (active,) = neighbour.model.effects
        assert active.effect.contains == "coulomb_friction"
        assert active.effect.joint == "outer"
        np.testing.assert_array_equal(neighbour.values[:5], with_friction.values[:5])
        values = dict(zip((p.name for p in active.fitted), neighbour.values[5:], strict=True))
        for own in with_friction.model.effects[0].fitted:
            if not any(p.name == own.name and p.begins for p in active.fitted):
                assert values.get(own.name, with_friction.values[5]) == with_friction.values[5]
    # Where no torque is missing scores tell, but of what has none.
    unscored = list(extended_models(replace(with_friction, is_missing=np.zeros(2, dtype=bool))))
    assert [neighbour.what for neighbour in unscored] == [("presliding_friction.outer",)]


def test_an_encoder_that_is_early_is_behind_no_filter_but_the_other_one_may_be(rubbing):
    """A time constant of less than nothing makes the filter's state grow without end."""
    late = replace(with_effect(rubbing, "time_offset.outer", 2e-3), is_missing=np.array([False, True]))
    for delay, behind in ((2e-3, "outer"), (-2e-3, "inner")):
        late = replace(late, values=np.append(late.values[:-1], delay))
        forms = [*extended_models(late)]
        keys = {active.effect.key for each in forms for active in each.model.effects}
        assert [key for key in keys if "filter" in key] == [f"encoder_filter.{behind}.first order"]


def test_what_is_there_is_not_proposed_again_but_an_extended_model_that_has_a_score_in_its_place(with_friction):
    found = {score.active.effect.key for score in scores_of(with_friction, named_only=True)}
    assert DRY not in found
    assert any(known(key).contains == "coulomb_friction" for key in found)


def test_a_filter_of_first_order_is_proposed_for_an_encoder_that_is_late_and_filtered_beyond_that():
    trial, share = measured(motion(), np.random.default_rng(3), noise=0.0), np.exp(-TIME[1] / 0.02)
    outer = trial.theta[:, 1] - trial.theta[:, 0]
    behind = lfilter([1.0 - share], [1.0, -share], outer, zi=[share * outer[0]])[0]
    filtered = replace(trial, theta=trial.theta + np.outer(behind - outer, [0.0, 1.0]))
    late = with_effect(fitted(recorded([filtered])), "time_offset.outer", 0.02)
    key = "encoder_filter.outer.first order"
    proposed = [each for each in additions(late, scores_of(late, named_only=True)) if each.what == (key,)]
    assert proposed
    for neighbour in proposed:
        assert [active.effect.key for active in neighbour.model.effects] == list(neighbour.what)
        assert neighbour.values[-1] == pytest.approx(late.values[-1])


@pytest.mark.parametrize(("step", "proposed"), [(1e-4, True), (0.009, True), (0.011, False)])
def test_lost_counts_below_half_an_encoder_s_step_are_not_proposed(step, proposed):
    trial = measured(motion(), np.random.default_rng(2))
    slipped = replace(trial, theta=trial.theta + 5e-3 * (TIME > 4.118)[:, None] * [0.0, 1.0])
    found = fitted(recorded([slipped], steps=1e-4))
    found = replace(found, recorded=replace(found.recorded, steps=np.full(2, step)))
    neighbours = additions(found, scores_of(found, named_only=True))
    assert ("encoder_slip.outer" in [neighbour.what[0] for neighbour in neighbours]) == proposed


def test_a_spring_without_stiffness_may_be_a_constant_torque_and_one_that_is_sure_not(rubbing):
    found = with_effect(rubbing, "joint_spring.outer", 0.0, 0.02)
    less = ("joint_spring.outer but for constant_torque.outer",)
    each = next(each for each in simplifications(found, 100.0) if each.what == less)
    assert each.model.labels == ("constant_torque.outer",)
    assert each.values == pytest.approx([*found.values[:-2], found.values[-1]])
    stiff = replace(found, values=np.array([*found.values[:-2], 5.0, 0.02]))
    assert less not in [each.what for each in simplifications(stiff, 100.0)]


def test_what_is_sure_may_go_only_where_more_is_hidden(rubbing):
    found = with_effect(rubbing, DRY, 5.0)
    assert strength(found.model, found.values, found.covariance, 0) > 100.0
    for missing in (False, True):
        hiding = replace(found, is_missing=np.array([False, missing]))
        dropped = [each for each in simplifications(hiding, 100.0) if not each.model.effects]
        assert [each.what for each in dropped] == [(DRY,)] * missing


def test_what_is_there_already_and_another_effect_has_become_without_a_parameter_is_one_effect(rubbing):
    dry = with_effect(rubbing, DRY, 5e-3)
    found = with_effect(dry, "stribeck_friction.outer", 2e-3, 0.0, 1.0)
    less = (f"stribeck_friction.outer but for {DRY}",)
    each = next(each for each in simplifications(found, 100.0) if each.what == less)
    assert each.model.labels == (DRY,)
    *others, torque, more, _, _ = found.values
    assert each.values == pytest.approx([*others, torque + more])


def test_what_one_trial_has_more_than_the_others_is_proposed_of_effects_that_are_there():
    rng = np.random.default_rng(4)
    trials = [measured(motion(start, dry=dry), rng) for start, dry in (((1.5, 1.2), 4e-4), ((1.4, 1.9), 8e-4))]
    found = fitted(recorded(trials))
    found = with_effect(found, DRY, 6e-3)
    proposed = {(s.active.effect.key, s.active.trial) for s in scores_of(found, named_only=True)}
    assert (DRY, 1) in proposed
    assert (DRY, 0) not in proposed  # it has less
    active = ActiveEffect(known(DRY), trial=1)
    assert active.is_difference
    of_all = unlikelihood(ActiveEffect(known(DRY)), found.recorded)
    assert unlikelihood(active, found.recorded) == pytest.approx(of_all + 2.0 * np.log(2.0))
    again = with_effect(found, DRY, 1e-3, trial=1)
    assert not [s for s in scores_of(again, named_only=True) if s.active == active]
    assert not [each for each in extended_models(again) if each.model.effects[-1].trial == 1]


def test_in_the_place_of_an_effect_others_begin_with_the_motion_and_without_it_but_what_does_as_much_beside_it(
    rubbing, scored
):
    found = with_effect(rubbing, "joint_spring.outer", *np.zeros(len(known("joint_spring.outer").parameters)))
    alternatives = list(replacements(found, 0, rubbing, scored, beside=[]))
    assert alternatives[0].what == (DRY,)
    for without, within in zip(alternatives[::2], alternatives[1::2], strict=True):
        assert without.what == within.what
        assert "joint_spring.outer" not in (*without.model.labels, *within.model.labels)
        np.testing.assert_array_equal(without.values[:5], rubbing.values)
        np.testing.assert_array_equal(within.values[:5], found.values[:5])
        assert (without.origin is rubbing, within.origin is found, within.again) == (True, True, True)
    assert DRY in [score.active.effect.key for score in scored]
    assert not list(replacements(found, 0, rubbing, scored, beside=scored))


def test_what_takes_an_effect_s_place_may_do_so_in_its_extended_forms_where_a_torque_is_missing(
    rubbing, scored, with_friction
):
    dry = next(additions(rubbing, scored))
    assert dry.what == (DRY,)
    forms = list(extended_replacements(rubbing, dry, rubbing))
    kinds = ("stribeck_friction", "drifting_friction", "presliding_friction")
    assert {form.what for form in forms} == {(f"{kind}.outer",) for kind in kinds}
    strengths = {form.values[len(rubbing.values)] for form in forms}
    assert strengths == {dry.values[-1]}
    assert not with_friction.leaves_more.any()
    assert not list(extended_replacements(with_friction, dry, rubbing))


def test_a_stop_that_a_joint_hits_once_may_be_what_an_impulse_is_taken_for(rubbing, with_friction):
    struck = with_effect(rubbing, "impulse.outer", 0.1, 1.0, trial=0)
    proposed = list(at_the_place_of(struck, 0))
    assert {neighbour.what[0] for neighbour in proposed} == {"end_stop.outer", "magnet.outer"}
    node = np.searchsorted(struck.recorded.swings[0].node_times, struck.values[-1])
    near = np.diff(struck.states[0][node - 2 : node + 2, :2], axis=1)[:, 0]
    for neighbour in proposed:
        stiffness, place, *_ = neighbour.values[5:]
        assert -0.5 < (place - near.min()) % (2.0 * np.pi) < np.ptp(near) + 0.5
        assert stiffness > 0.0
    assert not list(at_the_place_of(with_friction, 0))


def test_an_instant_takes_the_place_of_nothing(rubbing, with_friction):
    alternatives = replacements(
        with_friction, 0, rubbing, scores_of(rubbing, named_only=False, lasting=True), beside=[]
    )
    assert not any(active.effect.at_an_instant for alternative in alternatives for active in alternative.model.effects)


def test_viscous_friction_near_a_place_takes_that_of_a_harmonic_begun_where_it_does_most(rubbing):
    proposed = list(near_a_place(rubbing, known("varying_viscosity.outer.1 per turn")))
    assert {neighbour.model.labels for neighbour in proposed} == {("varying_viscosity.outer.near a place",)}
    assert len({neighbour.values[-4:].tobytes() for neighbour in proposed}) == len(proposed) == 3
    assert all(neighbour.again for neighbour in proposed)
    assert not list(near_a_place(rubbing, known(DRY)))


def test_a_simpler_model_lacks_one_effect_and_keeps_all_other_values(with_friction):
    found = with_effect(with_friction, "encoder_scale.inner", 1e-4)
    simpler = {neighbour.what: neighbour for neighbour in simplifications(found, sure=np.inf)}
    assert set(simpler) == {(DRY,), ("encoder_scale.inner",)}
    np.testing.assert_array_equal(simpler[(DRY,)].values, found.values[[0, 1, 2, 3, 4, 6]])
    assert simpler[(DRY,)].model.labels == ("encoder_scale.inner",)
    # One that is sure is not tried to be dropped.
    assert [neighbour.what for neighbour in simplifications(found, sure=16.0)] == [("encoder_scale.inner",)]


@pytest.mark.parametrize(
    ("key", "values", "trial"), [("encoder_slip.inner", (1e-3, 2.0), 0), ("magnet.inner", (1e-3, 0.5, 0.1, 0.1), None)]
)
def test_what_happens_at_an_instant_or_near_a_place_is_fitted_again_without_another_effect(
    with_friction, key, values, trial
):
    found = with_effect(with_friction, key, *values, trial=trial)
    again = {neighbour.what: neighbour.again for neighbour in simplifications(found, sure=np.inf)}
    assert again == {(DRY,): True, (key,): False}


def test_how_sure_a_strength_is_does_not_depend_on_the_units_of_what_is_beside_it(clean):
    """A base's compliance over A22 is below a millionth, and its frequency a hundred."""
    model = clean.model.with_effect(ActiveEffect(known("pivot_compliance.base.oscillating")))
    values, std = [*clean.values, 2.7e-7, 103.0, 0.3], [*np.ones(len(clean.values)), 2.7e-10, 0.26, 1.9e-3]
    assert strength(model, np.array(values), np.diag(np.square(std)), 0) == pytest.approx(1e6)


def test_what_was_added_last_is_tried_beside_the_best_rival_of_each_effect_before(rubbing):
    def beside(found, key, value):
        model = found.model.with_effect(ActiveEffect(known(key)))
        return replace(found, model=model, values=np.append(found.values, value))

    before, rival, other = (
        beside(rubbing, key, 1e-3) for key in ("time_offset.outer", "encoder_filter.outer", "encoder_offset.outer")
    )
    found = beside(before, "encoder_scale.inner", 0.02)
    (tried,) = beside_rivals(found, before, [found, before, rival, other, rubbing])
    assert tried.what == ("encoder_filter.outer",)
    assert tried.model.labels == ("encoder_filter.outer", "encoder_scale.inner")
    np.testing.assert_array_equal(tried.values, [*rival.values, 0.02])
    assert not [*beside_rivals(found, before, [found, before, rubbing])]
    # What the addition is another form of is not beside it.
    assert not [*beside_rivals(beside(before, "encoder_filter.outer.first order", 0.01), before, [rival])]


def test_two_models_together_have_the_effects_of_both_unless_they_are_in_one_joint(rubbing, with_friction):
    slipping = with_effect(rubbing, "encoder_slip.inner", 1e-3, 4.0, trial=0)
    pair, turned = together(with_friction, slipping)
    assert pair.what == turned.what == pair.model.labels == (DRY, "encoder_slip.inner")
    assert (pair.origin, turned.origin) == (with_friction, slipping)
    np.testing.assert_array_equal(pair.values, [*with_friction.values, *slipping.values[-2:]])
    assert not [*together(with_friction, with_effect(rubbing, "encoder_scale.outer", 1e-3))]
