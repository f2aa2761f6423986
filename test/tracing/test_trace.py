# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The whole way from a residual to the effect that explains it, on a pendulum that the package did not simulate."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing import carry_over, final_model
from cdp_ident.tracing.final_model import is_worse
from cdp_ident.tracing.neighbours import scores_of
from cdp_ident.tracing.select_effects import select_effects
from cdp_ident.tracing.trace import judged, trace
from scenarios.paper_rig import A22
from scenarios.twin import TEN_SECONDS, twin

pytestmark = pytest.mark.long

TORQUE = 0.004
KEY = "coulomb_friction.outer"
TIMES = np.arange(500) / 100.0
STARTS = ((math.pi + 1.5, math.pi + 0.8, 0.0, 0.0), (math.pi - 1.1, math.pi + 1.4, 0.0, 0.0), (4.4, 4.0, 0.0, 0.0))


def dry_friction_in_the_outer_joint(time, state):
    torque = -TORQUE * math.tanh((state[3] - state[2]) / 0.01)
    return -torque, torque


def swings(starts, torque, times=TIMES):
    return [
        twin(np.random.default_rng(index), start=start, times=times, noise=5e-4, torque=torque, tolerance=1e-8)
        for index, start in enumerate(starts)
    ]


@pytest.fixture(scope="module")
def identified():
    trials = swings(STARTS, dry_friction_in_the_outer_joint)
    return identify(trials[:2], trials[2:], IdentifyOptions(named_effects_only=True))


@pytest.fixture(scope="module")
def traced(identified):
    return trace(identified)


def judged_again(identified, selection):
    """Return the same with effects that were selected before: what is tried here is what follows."""
    return judged(identified, selection, (), lambda line: None)


def test_the_effect_is_named_in_its_joint_and_no_other_and_explains_all_but_the_noise(identified, traced):
    (effect,) = traced.effects
    assert (effect.active.effect.key, effect.certainty, effect.also_possible) == (KEY, "named", ())
    # It is as sure as the models with it are probable.
    assert effect.probability > 0.98
    assert effect.log10_odds > 10.0
    assert effect.rmse_holdout_before > effect.rmse_holdout_after == traced.after.holdout.rmse()
    noise = float(np.sqrt(np.mean(identified.data.noise**2)))
    assert traced.errors["effects"].holdout.rmse < 1.2 * noise < traced.errors["refined"].holdout.rmse
    for role in ("fit", "holdout"):
        stages = ("nominal", "search", "refined", "effects")
        nominal, search, refined, effects = (getattr(traced.errors[stage], role) for stage in stages)
        assert effects.rmse < refined.rmse < search.rmse < nominal.rmse
        assert effects.sse_free_run < refined.sse_free_run
    assert not traced.unexplained.significant


def test_its_torque_is_found_up_to_the_inertia_that_no_trial_shows(traced):
    (parameter,) = traced.effects[0].parameters
    # The physical values are the nearest to nominal ones; the torque scales with their inertia as all torques do.
    m1, m2, m0, l1, _, J1, *_ = traced.physical.values
    inertia = m1 * l1**2 + J1 + (m2 + m0) * 0.4**2
    assert parameter.value / inertia == pytest.approx(TORQUE / A22, rel=0.02)
    relative = parameter.std / parameter.value
    assert relative == pytest.approx(traced.physical.inertia_relative_std, rel=0.05)
    assert abs(inertia / A22 - 1) < 3 * relative


def test_the_final_values_are_those_of_all_that_was_measured(traced):
    final, judged = traced.completed.fit.values, traced.after.fit.values
    assert np.array_equal(final, traced.whole.values)
    assert not np.array_equal(final, judged)
    chosen = np.diag(traced.selection.after.covariance)
    assert np.all(np.diag(traced.whole.covariance) < chosen)
    assert np.all(np.abs(final - judged) < 5.0 * np.sqrt(chosen))


@pytest.fixture(scope="module")
def spoilt(identified):
    """The same, but that in the last of what is held out the rods are moved by hand."""
    *others, last = identified.data.holdout
    moved = np.where((last.time > 0.5 * last.duration)[:, None], 0.05, 0.0)
    return replace(
        identified, data=replace(identified.data, holdout=(*others, replace(last, theta=last.theta + moved)))
    )


def test_a_disturbance_in_what_is_held_out_is_told_and_has_no_part_in_the_values(spoilt, traced):
    found = judged_again(spoilt, traced.searched)
    assert np.array_equal(found.after.fit.values, traced.after.fit.values)
    assert found.errors["effects"].holdout.rmse > 10 * traced.errors["effects"].holdout.rmse
    assert found.unexplained.significant
    assert found.unexplained.times_noise > 10.0
    assert [effect.active.effect.key for effect in found.effects] == [KEY]


def test_what_predicts_held_out_motion_worse_than_the_paper_s_model_is_withdrawn(identified, traced, monkeypatch):
    monkeypatch.setattr(carry_over, "is_worse", lambda error, other: True)
    kept = judged_again(identified, traced.searched)
    assert kept.withdrawn.effects == (KEY,)
    assert kept.withdrawn.holdout == pytest.approx(traced.after.holdout.rmse(), rel=1e-6)
    assert kept.effects == ()
    assert kept.after is kept.before
    assert len(kept.completed.fit.values) == len(identified.fit.values)
    assert kept.selection.steps
    # Where nothing was found nothing is.
    assert trace(replace(identified, failure="no motion")).withdrawn is None


@pytest.mark.parametrize(("error", "worse"), [(0.9, False), (1.01, False), (1.03, True), (float("nan"), True)])
def test_a_model_is_worse_where_its_error_is_larger_beyond_chance_or_none(error, worse):
    assert is_worse(error, 1.0) == worse


def test_without_values_from_whole_swings_those_that_were_judged_stand_and_the_report_says_why(
    identified, traced, monkeypatch
):
    def fails(*arguments):
        raise IdentificationError("the most likely motion was not found in 60 steps")

    monkeypatch.setattr(final_model, "most_likely", fails)
    monkeypatch.setattr(final_model, "GaussNewton", fails)
    found = judged_again(identified, traced.searched)
    assert found.whole is None
    np.testing.assert_array_equal(found.completed.fit.values, found.after.fit.values)
    assert found.failures == ("values from whole swings: the most likely motion was not found in 60 steps",)
    assert found.unexplained.description == "what remains could not be examined"


def test_a_selection_that_is_stopped_keeps_the_effects_found_so_far_in_whose_choice_nothing_held_out_has_a_part(
    spoilt, traced
):
    lines = []
    stopped = trace(spoilt, lines.append, stop=lambda: any(line.startswith("added") for line in lines))
    assert stopped.selection.interrupted
    assert stopped.selection.steps == traced.selection.steps[:1]
    (effect,) = stopped.effects
    assert stopped.selection.steps[0].action == f"added {effect.active.effect.key}"
    assert stopped.errors["effects"].fit.rmse < stopped.errors["refined"].fit.rmse


def test_zeros_of_each_trial_are_kept_where_no_effect_is_found(identified):
    paper = identified.whole
    model, values = paper.model.with_zeros(paper.values, [0, 1])
    covariance = np.pad(paper.covariance, (0, 4)) + np.diag([0.0] * len(paper.values) + [1e-8] * 4)
    chosen = replace(paper, model=model, values=values, covariance=covariance)
    selection = replace(
        select_effects(identified, stop=lambda: True), after=chosen, scores=tuple(scores_of(chosen, named_only=True))
    )
    found = judged(identified, selection, (), lambda line: None)
    assert found.completed.fit.model.zeros == (0, 1)
    assert found.covariance.shape == covariance.shape


@pytest.mark.campaign
def test_a_spring_so_strong_that_the_papers_model_cannot_follow_is_begun_with():
    stiffness = 0.05

    def spring_across_the_outer_joint(time, state):
        torque = -stiffness * (state[1] - state[0])
        return -torque, torque

    starts = [(2.2 + 0.3 * index, 2.6, 0.0, 20.0) for index in range(2)]
    trials = swings(starts, spring_across_the_outer_joint, TEN_SECONDS[:1200])
    found = trace(identify(trials, [], IdentifyOptions()))
    assert not found.failure
    assert [effect.active.effect.key for effect in found.effects] == ["joint_spring.outer"]
    assert found.effects[0].parameters[0].shown == pytest.approx(stiffness / A22, rel=1e-3)
    assert not found.unexplained.significant
