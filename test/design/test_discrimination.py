"""Two effects that the trials do not distinguish, and the trial that does."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.candidate_trial import CandidateTrial, fit_to
from cdp_ident.design.discrimination import alternatives, can_be_the_same
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.next_trial import NextTrial
from cdp_ident.design.starts import Grid
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.refinement import refine
from cdp_ident.model.effects.catalogue import CATALOGUE
from scenarios.next_swing import MODEL, NOISE, TRUTH, covariance
from scenarios.weighted import WEIGHT

DRAG = next(effect for effect in CATALOGUE if effect.key == "quadratic_friction.outer")
MODEL_WITH = MODEL.with_effect(ActiveEffect(DRAG))
VALUES = np.append(TRUTH, 2e-4)


def moved(sampling, start, seed=None):
    """Return windows of a trial as the model with the effect has it, with noise where there is a seed."""
    before = Knowledge(MODEL_WITH, VALUES, np.eye(6), NOISE, sampling)
    windows = fit_to(CandidateTrial(*start), before).windows
    if seed is None:
        return list(windows)
    rng = np.random.default_rng(seed)
    return [replaced(window, window.theta + rng.normal(scale=NOISE, size=window.theta.shape)) for window in windows]


def replaced(window, theta):
    return replace(window, theta=theta)


@pytest.fixture(scope="module")
def exact(known):
    return moved(known.sampling, (np.pi + 0.6, np.pi + 0.4))


@pytest.fixture(scope="module")
def knowledge(known):
    fit = refine(MODEL_WITH, VALUES, moved(known.sampling, (np.pi + 0.6, np.pi + 0.4), 0))
    return Knowledge(MODEL_WITH, VALUES, covariance(fit), NOISE, known.sampling)


@pytest.fixture(scope="module")
def alternative(knowledge, exact):
    (found,) = alternatives(knowledge, exact, "quadratic_friction.outer", "coulomb_friction.outer")
    return found


def test_an_alternative_is_adjusted_to_what_the_fitted_model_says(alternative, exact):
    assert alternative.fit.model.labels == ("coulomb_friction.outer",)
    without = refine(MODEL, TRUTH, exact)
    assert 0 < alternative.fit.squared_error <= without.squared_error * (1 + 1e-6)
    assert not can_be_the_same(alternative)


def test_an_alternative_of_long_recordings_is_adjusted_to_a_share_that_stands_for_all(alternative, knowledge, exact):
    times = 30
    (found,) = alternatives(knowledge, exact * times, "quadratic_friction.outer", "coulomb_friction.outer")
    assert len(found.fit.windows) == found.share * times * len(exact) < times * len(exact)
    assert found.deviations_now == pytest.approx(np.sqrt(times) * alternative.deviations_now, rel=0.1)
    still = CandidateTrial(np.pi, np.pi)
    assert found.deviations(still) == pytest.approx(found.deviations_now)


def test_the_deviations_are_those_of_a_alternative_that_is_fitted_to_both_trials(alternative, known):
    start = (np.pi + 1.0, np.pi - 0.3)
    foretold = alternative.deviations(CandidateTrial(*start))
    both = refine(
        alternative.fit.model, alternative.fit.values, [*alternative.fit.windows, *moved(known.sampling, start)]
    )
    assert foretold == pytest.approx(np.sqrt(both.squared_error) / NOISE, rel=0.3)
    assert foretold > alternative.deviations_now


def test_so_they_are_of_a_trial_with_a_weight_whose_alternative_may_have_another_inertia(knowledge, exact):
    with_weight = knowledge.with_weights([WEIGHT])
    (found,) = alternatives(with_weight, exact, "quadratic_friction.outer", "coulomb_friction.outer")
    trial = CandidateTrial(np.pi + 0.6, np.pi + 0.5, (WEIGHT,))
    both = refine(found.fit.model, found.fit.values, [*found.fit.windows, *fit_to(trial, with_weight).windows])
    cost = both.squared_error + both.values @ both.model.penalty @ both.values
    assert found.fit.model.names[5:8] == with_weight.model.names[5:8]
    assert found.deviations(trial) == pytest.approx(np.sqrt(cost) / NOISE, rel=0.3)


def test_the_trial_that_is_advised_tells_them_apart_better_than_most(alternative, knowledge):
    found = NextTrial(knowledge, Grid.of(60.0)).furthest_apart(alternative)
    assert -found.survey.expected >= np.median(-found.survey.losses)
    assert -found.survey.expected > 2 * alternative.deviations_now


def test_rods_that_hang_still_tell_nothing_apart(alternative):
    assert alternative.deviations(CandidateTrial(np.pi, np.pi)) == pytest.approx(alternative.deviations_now)


def test_an_extended_model_of_an_effect_can_be_the_same(known):
    coulomb = next(effect for effect in CATALOGUE if effect.key == "coulomb_friction.outer")
    model, values = MODEL.with_effect(ActiveEffect(coulomb)), np.append(TRUTH, 0.01)
    with_friction = Knowledge(model, values, np.eye(6), NOISE, known.sampling)
    windows = fit_to(CandidateTrial(4.0, 3.8), with_friction).windows
    found = list(alternatives(with_friction, windows, "coulomb_friction.outer", "stribeck_friction.outer"))
    assert found
    assert all(can_be_the_same(alternative) for alternative in found)
