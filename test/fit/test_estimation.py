"""From the search box to the minimum."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.estimation import SHORT_IGA, estimate, search_objective
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import SYMBOLS, groups_of, physical_coefficients
from reference.pendulum import TABLE_5
from scenarios.start_given import CLOSE, StartGiven, balance_and_refine, search_and_refine
from scenarios.twin import standard_twin
from scenarios.weighted import plain_and_weighted

PRIOR = Prior()
MODEL = MotionModel(Mechanism.of(PRIOR))
PHYSICAL = np.array([TABLE_5[symbol] for symbol in SYMBOLS])
TRUTH = groups_of(PHYSICAL, TABLE_5["L"])
TWIN = standard_twin(np.random.default_rng(0))
WINDOWS = cut_into_windows([TWIN])
NOISE = 2.1e-3


@pytest.mark.parametrize("seeds", [8, pytest.param(100, marks=pytest.mark.campaign)])
def test_with_the_start_given_search_and_refinement_arrive_at_the_noise_from_every_seed(seeds):
    arrivals = [search_and_refine(StartGiven.of(seed), np.random.default_rng(seed)) for seed in range(seeds)]
    assert max(arrival.relative_error for arrival in arrivals) < CLOSE
    # pycma needs thousands of simulations for it (docs/benchmarks.md).
    assert max(arrival.simulations + 2 * arrival.passes for arrival in arrivals) < 800


def test_so_do_balance_of_forces_and_refinement():
    arrivals = [balance_and_refine(StartGiven.of(seed)) for seed in range(8)]
    assert max(arrival.relative_error for arrival in arrivals) < CLOSE


@pytest.mark.parametrize("seeds", [3, pytest.param(20, marks=pytest.mark.campaign)])
def test_with_starts_unknown_they_arrive_as_well(seeds):
    found = [estimate(MODEL, WINDOWS, PRIOR, NOISE, np.random.default_rng(seed)) for seed in range(seeds)]
    assert max(each.fit.rmse() for each in found) < NOISE
    assert all(each.searches == 1 for each in found)
    spread = np.sqrt(np.diag(covariance(found[0].fit)))
    assert np.all(np.abs(found[0].fit.values - TRUTH) < 4 * spread)


def test_the_same_seed_gives_the_same_result():
    first, second, other = (estimate(MODEL, WINDOWS, PRIOR, NOISE, np.random.default_rng(seed)) for seed in (5, 5, 6))
    assert np.array_equal(first.fit.values, second.fit.values)
    assert first.search.history == second.search.history != other.search.history


def test_an_error_far_above_the_noise_is_searched_for_again_until_two_searches_agree():
    found = estimate(MODEL, WINDOWS, PRIOR, NOISE / 100, np.random.default_rng(0))
    assert found.searches == 2
    assert found.evaluations > found.search.evaluations > SHORT_IGA.generations
    assert found.fit.rmse() < NOISE


def test_the_best_of_several_searches_is_kept(monkeypatch):
    errors = iter([3.0, 1.0, 2.0, 4.0])
    real = estimate.__globals__["refine_from_afar"]
    fits = []

    def worsened(model, values, windows):
        fit = real(model, values, windows)
        error = next(errors)
        fits.append(replace(fit, residuals=tuple(np.full_like(residual, error) for residual in fit.residuals)))
        return fits[-1]

    monkeypatch.setattr("cdp_ident.fit.estimation.refine_from_afar", worsened)
    found = estimate(MODEL, WINDOWS, PRIOR, NOISE, np.random.default_rng(0))
    assert found.searches == 4
    assert found.fit is fits[1]


def test_a_search_that_is_stopped_is_refined_and_not_repeated():
    found = estimate(MODEL, WINDOWS, PRIOR, NOISE / 100, np.random.default_rng(0), stop=lambda progress: "enough")
    assert found.searches == 1
    assert (found.search.completed, found.search.stopped) == (False, "enough")
    assert found.evaluations == SHORT_IGA.population


def test_where_the_search_has_missed_the_basin_the_balance_of_forces_leads_to_it(monkeypatch):
    real = estimate.__globals__["refine_from_afar"]
    begun = []

    def missed(model, values, windows):
        begun.append(values)
        fit = real(model, values, windows)
        if len(begun) > 1:  # the balance comes first
            fit = replace(fit, residuals=tuple(10.0 + residual for residual in fit.residuals))
        return fit

    monkeypatch.setattr("cdp_ident.fit.estimation.refine_from_afar", missed)
    roughly = 1.05 * TRUTH
    found = estimate(MODEL, WINDOWS, PRIOR, NOISE, np.random.default_rng(0), balanced=roughly)
    assert np.array_equal(begun[0], MODEL.initial_values(roughly))
    assert found.starting_values == "balance of forces"
    assert found.searches == 1
    assert found.fit.rmse() < NOISE


def test_a_balance_of_forces_that_leads_nowhere_better_changes_nothing():
    alone = estimate(MODEL, WINDOWS, PRIOR, NOISE, np.random.default_rng(0))
    with_it = estimate(MODEL, WINDOWS, PRIOR, NOISE, np.random.default_rng(0), balanced=1.05 * TRUTH)
    assert with_it.starting_values == "search"
    assert np.array_equal(with_it.fit.values, alone.fit.values)


def test_nothing_to_fit_is_refused():
    with pytest.raises(IdentificationError, match="nothing to fit: no window of any trial has enough samples"):
        estimate(MODEL, [], PRIOR, NOISE, np.random.default_rng(0))


@pytest.mark.parametrize(("span", "segments"), [(0.0, 4), (5.0, 2), (10.0, 1)])
def test_the_search_s_error_is_that_of_simulations_over_its_span(span, segments):
    error = search_objective(WINDOWS, span, PRIOR)(PHYSICAL[None])
    per_segment = len(WINDOWS) // segments
    expected = 0.0
    for first in range(0, len(WINDOWS), per_segment):
        beginning = WINDOWS[first]
        samples = slice(beginning.first, WINDOWS[first + per_segment - 1].samples.stop)
        time = TWIN.time[samples] - beginning.begin
        states = simulate(physical_coefficients(TABLE_5), beginning.start, time)
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


def test_groups_of_a_balance_that_give_no_motion_leave_the_search_alone():
    found = estimate(MODEL, WINDOWS, PRIOR, NOISE, np.random.default_rng(0), balanced=np.full(5, 1e150))
    assert found.starting_values != "balance of forces"
    assert found.fit.rmse() < NOISE
