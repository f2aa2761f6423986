# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The median of slopes against scipy's."""

import math

import numpy as np
import pytest
from scipy.stats import theilslopes

from cdp_ident.rig.device_clock import median_slope

ONE_SIGMA = math.erf(math.sqrt(0.5))
"""Probability of a normal number within one standard deviation."""


@pytest.mark.parametrize("digits", [12, 1, 0])
@pytest.mark.parametrize("count", [2, 6, 59])
def test_slope_and_interval_are_scipy_s_though_values_repeat(count, digits):
    rng = np.random.default_rng(count)
    for _ in range(20):
        x = np.cumsum(rng.uniform(0.5, 1.5, count))
        y = np.round(0.03 * x + rng.exponential(1.0, count), digits)
        expected = theilslopes(y, x, ONE_SIGMA)
        assert median_slope(x, y) == (expected.slope, expected.low_slope, expected.high_slope)


def test_values_that_are_all_equal_have_no_slope():
    assert median_slope(np.arange(6.0), np.ones(6)) == (0.0, 0.0, 0.0)
