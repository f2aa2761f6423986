# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Quadratic functions are minimised within limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.fit.bounded import minimum_within_limits

FREE = np.full(2, np.inf)


@pytest.mark.parametrize("scale", [np.ones(2), np.array([1e-9, 1e9])], ids=["alike", "of very different sizes"])
def test_without_active_limits_the_minimum_solves_the_linear_equations(scale):
    matrix, right = np.array([[2.0, 1.0], [1.0, 3.0]]), np.array([1.0, -2.0])
    found = minimum_within_limits(matrix * np.outer(scale, scale), right * scale, -FREE, FREE)
    assert found * scale == pytest.approx(np.linalg.solve(matrix, right), rel=1e-9)


def test_a_value_that_was_put_at_its_limit_is_released_where_that_lowers_the_function():
    # The free minimum, (-0.1, 6), is beyond the limits x0 >= 0 and x1 <= 1; once x1 is at 1, the best x0 is 4.4.
    matrix, right = np.array([[1.0, 0.9], [0.9, 1.0]]), np.array([5.3, 5.91])
    assert np.linalg.solve(matrix, right) == pytest.approx([-0.1, 6.0], abs=1e-9)
    assert minimum_within_limits(matrix, right, np.zeros(2), np.array([np.inf, 1.0])) == pytest.approx([4.4, 1.0])


def test_an_undetermined_direction_is_left_alone():
    matrix, right = np.diag([4.0, 0.0]), np.array([8.0, 0.0])
    assert minimum_within_limits(matrix, right, -FREE, FREE) == pytest.approx([2.0, 0.0])


def test_without_unknowns_there_is_nothing_to_solve_for():
    assert minimum_within_limits(np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.zeros(0)).shape == (0,)


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_at_the_minimum_no_value_could_move_within_its_limits_and_lower_the_function(seed, count):
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(count + 2, count))
    matrix, right = columns.T @ columns + 0.1 * np.eye(count), 3.0 * rng.normal(size=count)
    lower, upper = -rng.uniform(0.0, 1.0, count), rng.uniform(0.1, 1.0, count)
    found = minimum_within_limits(matrix, right, lower, upper)
    slope = matrix @ found - right
    assert np.all((found >= lower) & (found <= upper))
    assert np.all((slope < 1e-8) | (found <= lower + 1e-12))
    assert np.all((slope > -1e-8) | (found >= upper - 1e-12))
