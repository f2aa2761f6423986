# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What others make of a bag is put beside this package's."""

import numpy as np
import pytest

from benchmarks import _mujoco, _multiple_shooting, bag
from benchmarks._alternatives import LOWER, UPPER
from benchmarks.bag import ALTERNATIVES, BEGIN, OURS, TRUTH, WAYS, Result
from cdp_ident.model.parameters import groups_of
from reference.pendulum import TABLE_2, TABLE_5, motion

COUNT = 2.0 * np.pi / 8000.0
TIMES = np.arange(450) / 200.0  # no whole number of anyone's windows


@pytest.fixture(scope="module")
def theta():
    states = motion(TABLE_5, (2.2, 2.0, 0.0, 0.0), TIMES)
    joints = np.column_stack([states[:, 0], states[:, 1] - states[:, 0]])
    return np.cumsum(COUNT * np.round(joints / COUNT), axis=1)


def assert_near_truth(groups):
    np.testing.assert_allclose(groups[:3], TRUTH[:3], rtol=1e-3)
    np.testing.assert_allclose(groups[3:], TRUTH[3:], rtol=0.02)


def test_multiple_shooting_by_scipy_arrives(theta):
    assert_near_truth(_multiple_shooting.by_scipy(TIMES, theta, BEGIN))


def test_derivatives_for_scipy_are_those_of_the_residuals(theta):
    windows = _multiple_shooting._Windows(0.005, np.diff(theta, axis=1, prepend=0.0), BEGIN)
    starts = _multiple_shooting.filtered(TIMES, theta)[:: _multiple_shooting.SCIPY_WINDOW]
    unknowns = np.concatenate([np.ones(5), starts.ravel()])
    by = windows.derivatives(unknowns, 10.0)
    for place in (0, 4, 5, 12, len(unknowns) - 1):
        step = 1e-6 * np.eye(len(unknowns))[place]
        change = windows.residuals(unknowns + step, 10.0) - windows.residuals(unknowns - step, 10.0)
        np.testing.assert_allclose(by[:, place], change / 2e-6, rtol=1e-5, atol=1e-6 * np.abs(by).max())


@pytest.mark.skipif(not _multiple_shooting.has_casadi(), reason="CasADi is not installed")
def test_multiple_shooting_by_casadi_comes_to_the_same(theta):
    found = _multiple_shooting.by_casadi(TIMES, theta, BEGIN)
    assert_near_truth(found)
    np.testing.assert_allclose(found, _multiple_shooting.by_scipy(TIMES, theta, BEGIN), rtol=1e-4)


@pytest.mark.skipif(not _mujoco.can_identify(), reason="this MuJoCo has no system identification")
def test_system_identification_of_mujoco_follows_a_whole_swing(theta):
    states = _multiple_shooting.filtered(TIMES, theta)
    found = _mujoco.identify_swing(TIMES, theta, states, TABLE_2, LOWER, UPPER)
    assert_near_truth(groups_of(found, TABLE_5["L"]))


def rows_of(results):
    return {row[0]: row[1:] for row in bag.table_of(results).rows}


def test_medians_and_errors_over_the_bound():
    ours, *others = WAYS
    results = [Result(ours, (1e-5 * k, 4e-4), over, 0.2) for k, over in ((1, 1.0), (2, 1.0), (6, 2.32))]
    results += [Result(way, (1e-3, 1e-2), 100.0, 1.0) for way in others for _ in range(3)]
    rows = rows_of(results)
    assert rows[ours] == ("0.002 %", "0.006 %", "0.04 %", "1.2", "0.20", "1.0")
    assert rows[others[0]] == ("0.1 %", "0.1 %", "1 %", "10", "1.0", "5.0")


def test_a_way_of_which_nothing_came_says_why():
    first, *others = WAYS
    results = [Result(first, failure="the process ended with -9"), *(Result(way, (0.1, 0.1), 1, 1.0) for way in others)]
    assert rows_of(results)[first] == ("the process ended with -9", *[""] * 5)


def test_a_rival_that_is_not_installed_has_a_row():
    rows = rows_of([Result(way, (0.1, 0.1), 1.0, 1.0) for way in WAYS])
    assert list(rows)[: len(OURS)] == list(OURS)
    assert set(rows) == {*OURS, *ALTERNATIVES}
    assert all(rows[way][0] == "not installed" for way in ALTERNATIVES if way not in WAYS)
