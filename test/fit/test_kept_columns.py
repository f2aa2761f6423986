"""Columns that are zero are not kept, and are there again where they are asked for."""

import numpy as np
import pytest

from cdp_ident.fit.kept_columns import Normals, Sensitivities

WINDOWS = 600


@pytest.fixture(params=[5, 80])
def sensitivities(request):
    """Derivatives of which each window has three columns of its own."""
    rng, columns = np.random.default_rng(0), request.param
    parts = []
    for _ in range(WINDOWS):
        part = np.zeros((4, 2, columns))
        part[..., rng.choice(columns, 3, replace=False)] = rng.normal(size=(4, 2, 3))
        parts.append(part)
    return parts


def test_what_was_put_comes_back(sensitivities):
    kept = Sensitivities(WINDOWS, sensitivities[0].shape[-1])
    for index, whole in enumerate(sensitivities):
        kept.put(index, whole)
    assert len(kept) == WINDOWS
    assert all(np.array_equal(again, whole) for again, whole in zip(kept, sensitivities, strict=True))
    assert np.array_equal(kept[1:3][1], sensitivities[2])


def test_matrices_come_back_in_parts(sensitivities):
    columns = sensitivities[0].shape[-1]
    matrices = np.array([np.einsum("nrp,nrq->pq", part, part) for part in sensitivities])
    kept = Normals(WINDOWS, columns)
    for index, matrix in enumerate(matrices):
        kept.put(index, matrix)
    again = np.empty_like(matrices)
    for part, of_part in kept.parts():
        again[part] = of_part
        of_part[:] = 0.0  # what comes is a copy
    assert np.array_equal(again, matrices)
    vectors = np.random.default_rng(1).normal(size=(WINDOWS, columns))
    assert kept.times(vectors) == pytest.approx(np.einsum("wkl,wl->wk", matrices, vectors))
    assert np.array_equal(kept.diagonals, np.einsum("wkk->wk", matrices))
