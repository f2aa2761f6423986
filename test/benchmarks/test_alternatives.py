# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Other optimizers arrive, too, and are told when they have."""

import numpy as np
import pytest

from benchmarks import _mujoco
from benchmarks._alternatives import (
    LOWER,
    MOST_SIMULATIONS,
    UPPER,
    by_differential_evolution,
    by_least_squares,
    by_pycma,
)
from cdp_ident.model.parameters import groups_of
from reference.pendulum import TABLE_2, TABLE_3, TABLE_5, motion
from scenarios.paper_rig import GROUPS, LENGTH
from scenarios.start_given import CLOSE, StartGiven


@pytest.mark.parametrize(
    "method",
    [
        by_pycma,
        pytest.param(by_differential_evolution, marks=pytest.mark.campaign),
        pytest.param(by_least_squares, marks=pytest.mark.campaign),
    ],
)
def test_they_end_when_they_have_arrived(method):
    arrival = method(StartGiven.of(0), 0)
    assert arrival.relative_error < CLOSE
    assert 100 < arrival.simulations < MOST_SIMULATIONS


@pytest.mark.skipif(not _mujoco.can_identify(), reason="this MuJoCo has no system identification")
def test_system_identification_of_mujoco_finds_base_parameters():
    clock = np.arange(201) / 200.0
    theta = motion(TABLE_5, TABLE_3, clock)[:, :2]
    found = _mujoco.identify(clock, theta, np.array(TABLE_3), TABLE_2, LOWER, UPPER)
    np.testing.assert_allclose(groups_of(found, LENGTH), GROUPS, rtol=0.01)
