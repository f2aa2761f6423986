"""Problems that are laid out end to end."""

import numpy as np

from cdp_ident.model.initial_value_problem import EndToEnd, InitialValueProblem
from cdp_ident.model.time_grid import TimeGrid

SAMPLES = [3, 1, 2]


def laid_out():
    problems = []
    for place, samples in enumerate(SAMPLES):
        grid = TimeGrid.over(0.01 * np.arange(samples), 0.004)
        problems.append(
            InitialValueProblem(
                np.full(7, float(place)), np.arange(4.0 + place), grid, np.full(2 * grid.steps + 1, place), begin=place
            )
        )
    return problems, EndToEnd(problems)


def test_each_problem_s_inputs_steps_and_samples_are_between_its_bounds():
    problems, found = laid_out()
    step, u, of_u, first_sample, of_steps, place, of_samples = found.grids
    for k, problem in enumerate(problems):
        assert step[k] == problem.grid.step
        np.testing.assert_array_equal(u[of_u[k] : of_u[k + 1]], problem.u)
        np.testing.assert_array_equal(first_sample[of_steps[k] : of_steps[k + 1]], problem.grid.first_sample)
        np.testing.assert_array_equal(place[of_samples[k] : of_samples[k + 1]], problem.grid.place)
    assert (of_u[-1], of_steps[-1], of_samples[-1]) == (len(u), len(first_sample), sum(SAMPLES))


def test_initial_states_are_cut_or_filled_up_to_one_size():
    _, found = laid_out()
    assert found.starts(5).tolist() == [[0, 1, 2, 3, 0], [0, 1, 2, 3, 4], [0, 1, 2, 3, 4]]


def test_only_what_a_motion_did_not_reach_is_marked():
    _, found = laid_out()
    states, derivatives = np.zeros((6, 4)), np.zeros((6, 2, 1))
    found.mark_uncomputed(states, derivatives, np.array(SAMPLES))
    assert np.all(np.isfinite(states))
    found.mark_uncomputed(states, derivatives, np.array([1, 1, 2]))
    lost = [False, True, True, False, False, False]
    assert np.isnan(states).any(axis=1).tolist() == lost
    assert np.isnan(derivatives).any(axis=(1, 2)).tolist() == lost


def test_a_motion_that_is_no_number_at_its_end_is_marked_from_where_it_is_none():
    _, found = laid_out()
    states, derivatives = np.zeros((6, 4)), np.zeros((6, 2, 1))
    states[5, 2] = np.inf
    found.mark_uncomputed(states, derivatives, np.array(SAMPLES))
    lost = [False, False, False, False, False, True]
    assert np.isnan(states).all(axis=1).tolist() == lost
    assert np.isnan(derivatives).any(axis=(1, 2)).tolist() == lost
