# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Correlation of residuals in time."""

import numpy as np

from cdp_ident.fit.autocorrelation import autocovariance, correlation_length


def residuals(correlation):
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(20000, 2))
    for k in range(1, len(noise)):
        noise[k] = correlation * noise[k - 1] + np.sqrt(1 - correlation**2) * noise[k]
    return np.split(noise, 4)


def test_white_residuals_are_not_correlated():
    assert correlation_length(residuals(0.0)) <= 3


def test_those_of_a_first_order_process_are_until_it_is_forgotten():
    assert 10 < correlation_length(residuals(0.8)) < 40


def test_the_autocovariance_is_the_sum_of_products():
    parts = residuals(0.5)
    found = autocovariance(parts)
    for lag in (0, 3):
        expected = sum(np.sum(r[lag:] * r[: len(r) - lag], axis=0) for r in parts)
        np.testing.assert_allclose(found[lag], expected, rtol=1e-9)
