# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The next trial, and what it is worth when it is recorded."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.next_trial import NextTrial, loads_of, telling_weight
from cdp_ident.design.starts import Grid
from cdp_ident.model.weights import Weight
from scenarios.next_swing import ALL_GROUPS, PRIOR, Swings, swing
from scenarios.weighted import INERTIA, WEIGHT


@pytest.fixture(scope="module")
def first():
    return Swings.of([swing(np.pi + 0.5, np.pi + 0.7, np.random.default_rng(5))])


@pytest.fixture(scope="module")
def trials(first):
    return NextTrial(first.knowledge, Grid.of(30.0))


def recorded(trial, rng, weight=None):
    """Return a trial that was recorded as advised."""
    return swing(np.pi + trial.inner, np.pi + trial.outer, rng, weight=weight)


def exactly_there(survey):
    """The loss at the start to take, if the hand does not miss it."""
    return survey.losses.ravel()[survey.grid.trials(survey.trial.weights).index(survey.trial)]


@pytest.mark.parametrize(
    "names", [pytest.param(("c2_over_A22",), marks=pytest.mark.campaign), ALL_GROUPS], ids=["one", "all"]
)
def test_a_trial_as_advised_brings_what_was_foretold_and_more_than_most_random_starts(first, trials, names):
    rng = np.random.default_rng(6)
    found = trials.sharpest(names)
    now = first.knowledge.uncertainty(names)
    assert now.std == pytest.approx(first.standard_deviations(names), rel=1e-3)
    brought = first.with_one_more(recorded(found.trial, rng)).knowledge.uncertainty(names).size
    assert brought == pytest.approx(exactly_there(found), rel=0.3)
    assert found.expected < 0.5 * now.size
    random = [first.with_one_more(swing(*rng.uniform(0, 2 * np.pi, 2), rng)) for _ in range(5)]
    assert brought < np.median([swings.knowledge.uncertainty(names).size for swings in random])


@pytest.mark.parametrize(
    "weight",
    [
        replace(WEIGHT, mass_std=1e-9, place_std=1e-9),
        replace(WEIGHT, mass_std=5e-4, place_std=1e-3),
        Weight("inner", 0.1, 0.3, 1e-5, mass_std=1e-4, place_std=1e-4),
    ],
    ids=["as sure as the noise allows", "as sure as the weight", "on the inner rod"],
)
def test_a_trial_with_a_weight_brings_the_interval_of_the_inertia_that_was_foretold(first, weight):
    rng = np.random.default_rng(8)
    knowledge = first.knowledge.with_weights([weight])
    found = NextTrial(knowledge, Grid.of(60.0)).sharpest(("one_over_A22",), ((weight,),))
    assert np.all(np.isinf(knowledge.uncertainty(("one_over_A22",)).std))
    assert found.trial.weights == (weight,)
    both = first.with_one_more(recorded(found.trial, rng, weight))
    (std,) = both.standard_deviations(("one_over_A22",))
    assert std == pytest.approx(found.expected, rel=0.3)
    assert abs(both.fit.values[5] - 1.0 / INERTIA) < 3.0 * std < 0.1 / INERTIA


def test_each_start_is_tried_with_each_load_and_the_best_is_taken(first):
    heavy = replace(WEIGHT, mass=0.2, mass_std=1e-9, place_std=1e-9)
    loads = ((), (WEIGHT,), (heavy,))
    knowledge = first.knowledge.with_weights([WEIGHT, heavy])
    weighted_trials = NextTrial(knowledge, Grid.of(90.0))
    inertia = weighted_trials.sharpest(("one_over_A22",), loads[1:])
    assert inertia.trial.weights == (heavy,)
    assert inertia.unloaded is None
    groups = weighted_trials.sharpest(ALL_GROUPS, loads)
    bare, *weighted = (weighted_trials.sharpest(ALL_GROUPS, (load,)).expected for load in loads)
    assert groups.unloaded.expected == bare
    assert groups.expected == (bare if bare <= 1.05 * min(weighted) else min(weighted))


def test_a_weight_that_brings_hardly_more_is_not_advised(first):
    light = Weight("inner", 1e-4, 0.1)
    found = NextTrial(first.knowledge, Grid.of(90.0)).sharpest(ALL_GROUPS, ((light,), ()))
    assert found.trial.weights == ()
    assert found.expected == found.unloaded.expected


def test_the_standard_deviations_then_are_those_of_the_values_asked_for(trials):
    then = trials.uncertainty_after(trials.sharpest(ALL_GROUPS).trial, ALL_GROUPS)
    assert then.std.shape == (5,)
    assert np.all(then.std < trials.knowledge.uncertainty(ALL_GROUPS).std)


def test_who_asks_for_one_value_gets_the_start_that_is_best_for_it(trials):
    asked, all_of_them = trials.sharpest(("c1_over_A22",)), trials.sharpest(ALL_GROUPS)
    there = np.argwhere(all_of_them.losses == all_of_them.losses.min())[0]
    assert asked.losses.min() <= asked.losses[tuple(there)]


def test_the_map_is_as_symmetric_as_the_rig(trials):
    losses = trials.sharpest(("c2_over_A22",)).losses[:-1, :-1]  # without the rods that are upright
    assert losses == pytest.approx(losses[::-1, ::-1])


def test_who_asks_for_fewer_starts_gets_one_of_them_and_the_same_of_each(trials):
    few = trials.grid.thinned
    found, among_all = trials.sharpest(("c1_over_A22",), grid=few), trials.sharpest(("c1_over_A22",))
    assert found.trial in few.trials()
    assert np.array_equal(found.losses, among_all.losses[1::2, 1::2])


def test_starts_are_tried_without_a_weight_and_with_each_set_of_them_once():
    assert loads_of([]) == ((),)
    assert loads_of([(WEIGHT,), (), (WEIGHT,)]) == ((), (WEIGHT,))


def test_a_weight_that_would_show_the_inertia_adds_a_tenth_of_it_at_the_end_of_the_outer_rod(known):
    weight = telling_weight(known)
    assert weight.added(PRIOR.length)[0] == pytest.approx(0.1 * known.model.mechanism.inertia, rel=0.05)
    assert (weight.rod, weight.place) == ("outer", known.model.mechanism.outer_length)
    assert (weight.mass_std, weight.place_std) == (pytest.approx(0.01 * weight.mass), 1e-3)
