# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Steps to a maximum of the likelihood: how many they are, and which of several beginnings is followed."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import CLOSE_ENOUGH, ENOUGH_STEPS, NEAR, best_of
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.recorded import states_of
from scenarios.swings import BEGIN, MODEL, TIME, TRUE, known, measured, motion, recorded, with_effect

NOWHERE = np.full(len(BEGIN), np.nan)


@pytest.fixture(scope="module")
def swings():
    return recorded([measured(motion(), np.random.default_rng(0))], NEAR)


def searches(swings, *beginnings):
    states, noise = states_of(swings, MODEL), Noise.white(swings.encoders, swings.large_torque)
    return [GaussNewton(MODEL, values, swings, states, noise, CLOSE_ENOUGH) for values in beginnings]


def test_unknown_torques_that_are_not_there_vanish_within_few_steps_of_values(swings):
    """They begin a hundred thousand times too large: each linearisation serves for as many estimates as it can."""
    (search,) = searches(swings, BEGIN)
    found = search.run().found()
    assert found.converged
    assert found.steps <= 5
    assert np.all(found.noise.torque < 0.05 * swings.large_torque)
    assert not np.any(found.is_missing)
    assert np.abs((found.values - TRUE) / np.sqrt(np.diag(found.covariance))).max() < 4.0


def test_what_goes_on_ends_where_it_would_have_ended_at_once(swings):
    (at_once,) = searches(swings, BEGIN)
    (in_parts,) = searches(swings, BEGIN)
    one, other = at_once.run().found(), in_parts.run(1).run().found()
    assert other.misfit == pytest.approx(one.misfit, abs=0.5)
    assert np.abs((other.values - one.values) / np.sqrt(np.diag(one.covariance))).max() < CLOSE_ENOUGH


def test_of_several_beginnings_the_best_is_followed_to_the_end(swings):
    alone, _ = best_of(searches(swings, BEGIN))
    found, failures = best_of(searches(swings, TRUE * [1.0, 1.0, 3.0, 1.0, 1.0], BEGIN))
    assert found.converged
    assert failures == []
    assert found.misfit == pytest.approx(alone.misfit, abs=0.5)


def test_a_beginning_without_a_motion_costs_that_one_alone(swings):
    found, failures = best_of(searches(swings, NOWHERE, BEGIN))
    assert found.converged
    assert failures == ["the motion between nodes cannot be computed"]
    assert best_of(searches(swings, NOWHERE, NOWHERE)) == (None, 2 * failures)


def test_what_does_not_keep_its_promise_after_a_few_steps_is_given_up(swings):
    found, _ = best_of(searches(swings, BEGIN))
    assert best_of(searches(swings, BEGIN), promised=found.misfit - 1.0) == (None, [])
    assert best_of(searches(swings, BEGIN), promised=found.misfit + 1e4)[0].misfit == pytest.approx(found.misfit)


def test_an_instant_at_which_nothing_happens_stays_in_its_trial(swings):
    """Its derivative is next to nothing: a step had led to 1e85 s."""
    found, _ = best_of(searches(swings, BEGIN))
    for size in (0.0, 1e-9, 1e-5):
        time = with_effect(found, "encoder_slip.outer", size, 4.0, trial=0).values[-1]
        assert 0.0 <= time <= TIME[-1] + 1.0


@pytest.mark.parametrize(("joint", "begins"), [("inner", 4.1), ("outer", 4.14)])
def test_counts_are_lost_between_the_samples_that_show_it(joint, begins):
    lost, shown = 0.05, [1.0, 1.0] if joint == "inner" else [0.0, 1.0]
    trial = measured(motion(), np.random.default_rng(2))
    slipped = recorded([replace(trial, theta=trial.theta + lost * (TIME > 4.118)[:, None] * shown)], NEAR)
    model = MODEL.with_effect(ActiveEffect(known(f"encoder_slip.{joint}"), trial=0))
    noise, values = Noise.white(slipped.encoders, slipped.large_torque), np.append(BEGIN, [lost, begins])
    found, _ = best_of([GaussNewton(model, values, slipped, states_of(slipped, model), noise, CLOSE_ENOUGH)])
    assert found.values[-2:] == pytest.approx([lost, 4.12], abs=1e-4)
    assert not np.any(found.leaves_more)


def test_no_more_steps_are_made_than_asked_for(swings):
    found, _ = best_of(searches(swings, BEGIN, BEGIN), most_steps=0)
    assert found.steps == 0
    assert np.array_equal(found.values, BEGIN)
    found, _ = best_of(searches(swings, BEGIN))
    assert 0 < found.steps < ENOUGH_STEPS
