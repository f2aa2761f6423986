# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the search makes small, and where that leads."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.objective import search_objective
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.motions import simulate
from scenarios.paper_rig import COEFFICIENTS, PHYSICAL
from scenarios.start_given import CLOSE, StartGiven, balance_and_fit, search_and_fit
from scenarios.twin import standard_twin
from scenarios.weighted import plain_and_weighted

PRIOR = Prior()
TWIN = standard_twin(np.random.default_rng(0))
WINDOWS = cut_into_windows([TWIN])


@pytest.mark.parametrize("seeds", [8, pytest.param(100, marks=pytest.mark.campaign)])
def test_with_the_start_given_search_and_whole_swings_arrive_at_the_noise_from_every_seed(seeds):
    arrivals = [search_and_fit(StartGiven.of(seed), np.random.default_rng(seed)) for seed in range(seeds)]
    assert max(arrival.relative_error for arrival in arrivals) < CLOSE
    # pycma needs thousands of simulations for it (docs/benchmarks.md).
    assert max(arrival.simulations + 2 * arrival.passes for arrival in arrivals) < 800


def test_so_do_balance_of_forces_and_whole_swings():
    arrivals = [balance_and_fit(StartGiven.of(seed)) for seed in range(8)]
    assert max(arrival.relative_error for arrival in arrivals) < CLOSE


@pytest.mark.parametrize(("span", "segments"), [(0.0, 4), (5.0, 2), (10.0, 1)])
def test_the_search_s_error_is_that_of_simulations_over_its_span(span, segments):
    error = search_objective(WINDOWS, span, PRIOR)(PHYSICAL[None])
    per_segment = len(WINDOWS) // segments
    expected = 0.0
    for first in range(0, len(WINDOWS), per_segment):
        beginning = WINDOWS[first]
        samples = slice(beginning.first, WINDOWS[first + per_segment - 1].samples.stop)
        time = TWIN.time[samples] - beginning.begin
        states = simulate(COEFFICIENTS, beginning.start, time)
        expected += np.sum((states[:, :2] - TWIN.theta[samples]) ** 2)
    assert error == pytest.approx([expected], rel=1e-6)


def test_the_search_does_not_see_windows_that_are_not_given_to_it():
    theta = TWIN.theta.copy()
    theta[1000:1500] += np.random.default_rng(0).normal(0, 10, (500, 2))
    given = [
        [window for window in cut_into_windows([trial]) if window.begin != 5.0]
        for trial in (TWIN, replace(TWIN, theta=theta))
    ]
    for span in (0.0, 10.0):
        errors = [search_objective(windows, span, PRIOR)(PHYSICAL[None]) for windows in given]
        assert np.array_equal(*errors)


def test_the_search_takes_each_trial_with_its_weights():
    trials = plain_and_weighted(np.random.default_rng(0))
    plain, weighted = (search_objective(cut_into_windows([trial]), 0.0, PRIOR)(PHYSICAL[None]) for trial in trials)
    assert weighted == pytest.approx(plain, rel=0.5)
    untold = search_objective(cut_into_windows([replace(trials[1], weights=())]), 0.0, PRIOR)(PHYSICAL[None])
    assert untold > 10.0 * weighted
    assert search_objective(cut_into_windows(trials), 0.0, PRIOR)(PHYSICAL[None]) == pytest.approx(plain + weighted)


def test_segments_do_not_reach_from_one_trial_into_the_next():
    both = search_objective(cut_into_windows([TWIN, TWIN]), 20.0, PRIOR)(PHYSICAL[None])
    assert both == pytest.approx(2 * search_objective(WINDOWS, 20.0, PRIOR)(PHYSICAL[None]))
