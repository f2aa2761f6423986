# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from benchmarks.balance import RIGS
from benchmarks.rigs import NOMINAL_ERROR, RANGES, design, examine, nominal, physical
from cdp_ident.model.parameters import SYMBOLS, groups_of

SHORT = design()[12]
"""2 s of a rig of 0.3 m that its viscous friction alone damps."""


def test_the_physical_values_are_those_of_the_motion():
    for case in design():
        values = physical(case)
        groups = groups_of(np.array([values[symbol] for symbol in SYMBOLS]), values["L"])
        np.testing.assert_allclose(groups, case.truth[: len(groups)], rtol=1e-12)


def test_a_user_knows_length_and_gravity_and_is_wrong_about_the_rest():
    true, known = physical(SHORT), nominal(SHORT, np.random.default_rng(0))
    assert (known["L"], known["g"]) == (true["L"], true["g"])
    off = np.array([known[symbol] / true[symbol] - 1.0 for symbol in SYMBOLS if true[symbol]])
    assert 0.0 < np.min(np.abs(off)) < np.max(np.abs(off)) < NOMINAL_ERROR


def test_the_design_reaches_all_limits_and_goes_beyond_none():
    points = np.array([(case.length, case.rate, case.duration, case.noise) for case in design()])
    np.testing.assert_allclose(np.stack([points.min(axis=0), points.max(axis=0)], axis=1), RANGES)
    assert {case.rig for case in design()} == set(RIGS)


@pytest.mark.campaign
def test_a_rig_is_examined_from_its_recording_to_its_intervals():
    result = examine(SHORT)
    assert result.outcome == "fitted"
    assert max(map(abs, result.deviations)) < 3.0
    assert result.named == ()
    assert result.after < 1.1
