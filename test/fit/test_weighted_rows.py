"""Rows are whitened and weighted, and multiplied, as linear algebra does it."""

from itertools import pairwise

import numpy as np
import pytest

from cdp_ident.fit.weighted_rows import ROOM, WeightedRows

LIMIT = 1.5
BOUNDS = np.array([0, 1, 6, 29])
"""Windows of fewer samples than are multiplied at a time, and of more."""


@pytest.mark.parametrize("limit", [LIMIT, np.inf])
@pytest.mark.parametrize(
    "columns", [np.arange(1), np.arange(4), np.array([5, 0, 30]), np.arange(24), np.arange(ROOM + 9)]
)
def test_normal_equations_are_those_of_whitened_and_weighted_rows(limit, columns):
    rng = np.random.default_rng(0)
    samples = BOUNDS[-1]
    measured, simulated = rng.normal(size=(2, samples, 2))
    derivatives = rng.normal(size=(samples, 2, ROOM + 9))
    whitening = rng.normal(size=(samples, 2, 2))
    found = WeightedRows.of(measured, simulated, derivatives, columns, whitening, BOUNDS, limit)
    residuals = np.einsum("nkl,nl->nk", whitening, measured - simulated)
    np.testing.assert_allclose(found.residuals, residuals)
    np.testing.assert_allclose(found.sensitivities, whitening @ derivatives[..., columns], atol=1e-12)
    beyond = np.abs(residuals) > limit
    np.testing.assert_allclose(
        found.weights, np.where(beyond, limit / np.abs(residuals), 1.0) if limit < np.inf else 1.0
    )
    for window, (first, end) in enumerate(pairwise(BOUNDS.tolist())):
        rows = found.sensitivities[first:end].reshape(-1, len(columns))
        weighted, left = rows * found.weights[first:end].reshape(-1, 1), residuals[first:end].ravel()
        np.testing.assert_allclose(found.normal[window], weighted.T @ rows, atol=1e-10)
        np.testing.assert_allclose(found.right[window], weighted.T @ left, atol=1e-10)
        size = np.abs(left)
        huber = np.where(size > LIMIT, LIMIT * (2.0 * size - LIMIT), size**2) if limit < np.inf else size**2
        assert found.costs[window] == pytest.approx(huber.sum())


def test_a_residual_that_is_no_number_shows_in_its_own_window_s_cost():
    angles = np.zeros((BOUNDS[-1], 2))
    angles[3] = np.nan
    derivatives, whitening = np.ones((len(angles), 2, 1)), np.tile(np.eye(2), (len(angles), 1, 1))
    found = WeightedRows.of(angles, np.zeros_like(angles), derivatives, np.arange(1), whitening, BOUNDS, np.inf)
    assert np.isfinite(found.costs).tolist() == [True, False, True]
