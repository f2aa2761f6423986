# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What makes a trial good."""

import numpy as np
import pytest

from cdp_ident.design.criteria import Uncertainty, covariance_of
from scenarios.next_swing import ALL_GROUPS


def test_one_value_is_as_uncertain_as_its_standard_deviation(known):
    found = Uncertainty.of(known, ("c1_over_A22",), known.rows)
    std = np.sqrt(known.covariance[3, 3])
    assert (found.std, found.size) == (pytest.approx([std]), pytest.approx(std))


def test_several_are_as_uncertain_as_the_determinant_of_their_covariance_says(known):
    names = ("A23_over_A22", "c1_over_A22")
    part = known.covariance[np.ix_([0, 3], [0, 3])]
    assert Uncertainty.of(known, names, known.rows).size == pytest.approx(np.linalg.det(part) ** (1 / 4))


def test_four_times_the_information_halves_it(known):
    now = Uncertainty.of(known, ALL_GROUPS, known.rows).size
    assert Uncertainty.of(known, ALL_GROUPS, 2 * known.rows).size == pytest.approx(now / 2)


def test_what_is_not_seen_is_infinitely_uncertain_and_the_rest_is_not():
    rows = np.diag([2.0, 0.0, 1.0])
    assert np.diag(covariance_of(rows)) == pytest.approx([0.25, np.inf, 1.0])
    together = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert np.diag(covariance_of(together)) == pytest.approx([np.inf, np.inf, 1.0])
