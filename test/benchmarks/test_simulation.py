# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What simulation is compared with computes the same motion."""

import numpy as np
import pytest

from benchmarks import _compiled_c, _mujoco
from benchmarks.simulation import COEFFICIENTS, START, by_numpy, by_scipy
from cdp_ident.model.motions import InitialValueProblem, motions
from cdp_ident.model.parameters import coefficients_of, groups_of
from cdp_ident.model.population import Population, Segment
from cdp_ident.model.time_grid import TimeGrid
from reference.pendulum import TABLE_3, TABLE_5, motion
from scenarios.search_problem import LOWER, UPPER

CLOCK = np.arange(200) / 200.0
STEP = 0.005
needs_compiler = pytest.mark.skipif(not _compiled_c.is_there(), reason="no C compiler")


@pytest.fixture(scope="module")
def measured():
    return np.ascontiguousarray(motion(TABLE_5, TABLE_3, CLOCK)[:, :2])


@pytest.fixture(scope="module")
def coefficients():
    physical = np.random.default_rng(0).uniform(LOWER, UPPER, (2 * _compiled_c.LANES, len(LOWER)))
    return coefficients_of(groups_of(physical, TABLE_5["L"]), TABLE_5["L"], TABLE_5["g"])


@pytest.fixture(scope="module")
def expected(measured, coefficients):
    return Population([Segment(START, CLOCK, measured)]).squared_errors(coefficients)[:, 0]


@pytest.mark.parametrize(
    "computed",
    [
        pytest.param(_compiled_c.population, marks=needs_compiler),
        pytest.param(_compiled_c.one_by_one, marks=needs_compiler),
        by_numpy,
    ],
)
def test_squared_errors_of_populations(computed, measured, coefficients, expected):
    np.testing.assert_allclose(computed(coefficients, START, STEP, measured), expected, rtol=1e-9)


@needs_compiler
def test_windows_with_derivatives():
    grid = TimeGrid.over(np.arange(50) / 130.0)
    starts = START + np.random.default_rng(0).normal(scale=0.05, size=(_compiled_c.WINDOWS, 4))
    angles, derivatives = _compiled_c.windows(COEFFICIENTS, starts, grid)
    u = np.zeros(2 * grid.steps + 1)
    found = motions([InitialValueProblem(COEFFICIENTS, start, grid, u) for start in starts], derive=True, shown=False)
    np.testing.assert_allclose(angles.reshape(-1, 2), found.states[:, :2], atol=1e-12)
    np.testing.assert_allclose(derivatives.reshape(-1, 2, 11), found.by[:, :2], atol=1e-9)


def test_the_motion_of_scipy_and_mujoco(measured):
    moved = _mujoco.rollout(_mujoco.models_of([TABLE_5]), START, len(CLOCK) - 1)[0]
    np.testing.assert_allclose(moved, measured, atol=1e-6)
    np.testing.assert_allclose(by_scipy(COEFFICIENTS, START, CLOCK, tolerance=1e-9)[:, :2], measured, atol=1e-6)


@needs_compiler
def test_compiled_c_leaves_the_process_its_subnormal_numbers(measured, coefficients):
    _compiled_c.population(coefficients, START, STEP, measured)
    assert float(np.nextafter(0.0, 1.0)) * 1.0 > 0.0
