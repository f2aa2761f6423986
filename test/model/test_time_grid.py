# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import OptionError
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid

ascending_times = st.lists(st.floats(0, 20), min_size=1, max_size=60).map(lambda times: np.sort(np.array(times)))
steps = st.floats(1e-3, 0.1)


def step_of_each_sample(grid):
    return np.repeat(np.arange(grid.steps), np.diff(grid.first_sample))


@given(times=ascending_times, step=steps)
def test_every_sample_lies_in_exactly_one_step_and_within_it_and_no_step_is_made_after_the_last(times, step):
    grid = TimeGrid.over(times, step)
    assert grid.first_sample[0] == 0
    assert grid.first_sample[-1] == len(times)
    begin = step_of_each_sample(grid) * step
    assert np.all(times >= begin - 1e-9)
    assert np.all(times <= begin + step * (1 + 1e-6))
    assert (grid.steps - 1) * step < times[-1] or grid.steps == 1


@given(times=ascending_times, step=steps, cubic=st.lists(st.floats(-2, 2), min_size=4, max_size=4))
def test_a_cubic_between_steps_is_read_exactly(times, step, cubic):
    grid, motion = TimeGrid.over(times, step), np.polynomial.Polynomial(cubic, domain=[0, 20], window=[-1, 1])
    begin = step_of_each_sample(grid) * step
    slope = motion.deriv()
    ends = np.stack([motion(begin), motion(begin + step), slope(begin), slope(begin + step)], axis=1)
    np.testing.assert_allclose(np.sum(grid.weights * ends, axis=1), motion(times), atol=1e-12)


@pytest.mark.parametrize("rate", [100, 200, 1000 / 3, 500, 1000])
def test_samples_at_the_ends_of_steps_need_no_step_of_their_own(rate):
    times = np.arange(2001) / rate
    step = 1 / rate
    grid = TimeGrid.over(times, step)
    assert grid.steps == 2000
    np.testing.assert_array_equal(np.diff(grid.first_sample), [2] + [1] * 1999)
    np.testing.assert_allclose(grid.weights[1:], np.tile([0.0, 1.0, 0.0, 0.0], (2000, 1)), atol=1e-6)


def test_inputs_are_looked_at_from_the_start_to_the_end_of_the_last_step():
    grid = TimeGrid.over(np.array([0.0, 0.012]), 0.005)
    np.testing.assert_allclose(grid.half_step_times(), [0, 0.0025, 0.005, 0.0075, 0.01, 0.0125, 0.015])


def test_the_grid_keeps_pace_over_an_hour():
    times = np.arange(3_600 * 200) / 200.0
    grid = TimeGrid.over(times)
    assert grid.step == DEFAULT_STEP == 0.005  # the paper's
    assert grid.steps == len(times) - 1


@pytest.mark.parametrize(
    ("times", "step", "message"),
    [
        ([], 0.005, "list of finite times"),
        ([[0.0, 1.0]], 0.005, "list of finite times"),
        ([0.0, np.inf], 0.005, "list of finite times"),
        ([0.0, 2.0, 1.0], 0.005, "must ascend"),
        ([-1e-3, 1.0], 0.005, "before its start"),
        ([0.0, 1.0], -0.005, "must be positive"),
        ([0.0, 1.0], np.inf, "must be positive"),
    ],
)
def test_times_and_steps_that_make_no_sense_are_refused(times, step, message):
    with pytest.raises(OptionError, match=message):
        TimeGrid.over(np.array(times), step)


def test_torques_between_their_samples_are_cubics_and_hold_beyond_the_ends():
    times = np.arange(0.0, 1.0, 0.005)
    torques = np.column_stack([np.sin(13.0 * times), np.cos(13.0 * times)])
    grid = TimeGrid.over(times[:100])
    at, found = grid.half_step_times(), grid.at_half_steps(times, torques, 0.2)
    np.testing.assert_allclose(found[:, 0], np.sin(13.0 * (0.2 + at)), atol=3e-6)  # straight lines: 5e-4
    np.testing.assert_array_equal(grid.at_half_steps(times[:2], torques[:2], 0.2)[0], torques[1])
