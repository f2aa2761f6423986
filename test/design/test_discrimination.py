# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two effects that the trials do not distinguish, and the trial that does."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.discrimination import RecordedMotion, alternatives
from cdp_ident.design.next_trial import NextTrial
from cdp_ident.design.starts import CandidateTrial, Grid, swing_of
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.trial.trial import Trial
from scenarios.next_swing import MODEL, NOISE, TRUTH, Swings
from scenarios.weighted import WEIGHT


def model_with(key, value):
    """Return the rig's model with an effect, and its values."""
    effect = next(effect for effect in CATALOGUE if effect.key == key)
    return MODEL.with_effect(ActiveEffect(effect)), np.append(TRUTH, value)


DRAG, FRICTION = "quadratic_friction.outer", "coulomb_friction.outer"
FIRST, SECOND = CandidateTrial(0.6, 0.4), CandidateTrial(1.0, -0.3)


def recorded(known, model, values, candidate, seed=0):
    """Return a trial as a model has it, with noise."""
    of, _ = swing_of(candidate, replace(known, model=model, values=values))
    readings = of.readings + np.random.default_rng(seed).normal(scale=NOISE, size=of.readings.shape)
    return Trial("swing", of.time, np.cumsum(readings, axis=1))


@pytest.fixture(scope="module")
def trials(known):
    return [recorded(known, *model_with(DRAG, 4e-4), one, seed) for seed, one in enumerate((FIRST, SECOND))]


@pytest.fixture(scope="module")
def knowledge(trials):
    return Swings.of(trials[:1], *model_with(DRAG, 4e-4)).knowledge


@pytest.fixture(scope="module")
def alternative(knowledge, trials):
    (found,) = alternatives(knowledge, RecordedMotion.of(knowledge, trials[:1]), DRAG, FRICTION)
    return found


def misfit_apart(trials):
    """Return by how much less likely the trials are with the other effect, fitted like the one that is there."""
    fits = [Swings.of(trials, *model_with(key, value)).fit for key, value in ((DRAG, 4e-4), (FRICTION, 1e-3))]
    return fits[1].misfit - fits[0].misfit


def test_two_effects_are_as_far_apart_as_fits_of_both_say(alternative, trials):
    assert alternative.model.labels == (FRICTION,)
    assert alternative.deviations_now**2 == pytest.approx(misfit_apart(trials[:1]), rel=0.5)
    assert not alternative.can_be_the_same


def test_with_a_further_trial_they_are_as_far_apart_as_fits_to_both_trials_say_then(alternative, trials):
    foretold = alternative.deviations(SECOND)
    assert foretold > 2.0 * alternative.deviations_now
    assert foretold**2 == pytest.approx(misfit_apart(trials), rel=0.3)


def test_of_long_recordings_a_share_stands_for_all(alternative, knowledge, trials):
    times, (trial, _) = 30, trials
    (found,) = alternatives(knowledge, RecordedMotion.of(knowledge, [trial] * times), DRAG, FRICTION)
    assert found.deviations_now == pytest.approx(np.sqrt(times) * alternative.deviations_now, rel=0.1)
    still = CandidateTrial(0.0, 0.0)
    assert found.deviations(still) == pytest.approx(found.deviations_now, rel=0.01)


def test_samples_that_were_averaged_stand_for_all(alternative, knowledge, trials):
    trial = trials[0]
    thinned = Trial("thinned", trial.time[::4], trial.theta[::4])
    (found,) = alternatives(knowledge, RecordedMotion.of(knowledge, [thinned]), DRAG, FRICTION)
    assert found.deviations_now == pytest.approx(alternative.deviations_now, rel=0.1)


def test_a_film_with_lost_frames_is_one_stretch_as_it_is_for_the_fit(alternative, knowledge, trials):
    kept = np.arange(len(trials[0].time)) % 6 < 4
    film = replace(trials[0], time=trials[0].time[kept], theta=trials[0].theta[kept])
    (found,) = alternatives(knowledge, RecordedMotion.of(knowledge, [film]), DRAG, FRICTION)
    assert 0.6 * alternative.deviations_now < found.deviations_now < 1.1 * alternative.deviations_now


def test_a_trial_with_a_weight_tells_them_apart_though_the_alternative_may_have_another_inertia(knowledge, trials):
    with_weight = knowledge.with_weights([WEIGHT])
    (found,) = alternatives(with_weight, RecordedMotion.of(with_weight, trials[:1]), DRAG, FRICTION)
    assert found.model.names[5:8] == with_weight.model.names[5:8]
    assert found.deviations(replace(FIRST, weights=(WEIGHT,))) > found.deviations_now


def test_the_trial_that_is_advised_tells_them_apart_better_than_most(alternative, knowledge):
    found = NextTrial(knowledge, Grid.of(60.0)).furthest_apart(alternative)
    assert -found.expected >= np.median(-found.losses)
    assert -found.expected > 2 * alternative.deviations_now


def test_rods_that_hang_still_tell_nothing_apart(alternative):
    still = alternative.deviations(CandidateTrial(0.0, 0.0))
    assert still == pytest.approx(alternative.deviations_now, rel=0.01)


def test_an_extended_model_of_an_effect_can_be_the_same(known):
    model, values = model_with(FRICTION, 0.01)
    trial = recorded(known, model, values, CandidateTrial(0.86, 0.66))
    knowledge = Swings.of([trial], model, values).knowledge
    found = list(alternatives(knowledge, RecordedMotion.of(knowledge, [trial]), FRICTION, "stribeck_friction.outer"))
    assert found
    assert all(alternative.can_be_the_same for alternative in found)
