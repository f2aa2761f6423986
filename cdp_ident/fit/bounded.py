# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Quadratic functions minimised within limits."""

import numpy as np
from scipy.optimize import lsq_linear

from cdp_ident.arrays import Array

UNDETERMINED = 1e-14
"""Eigenvalue of the scaled matrix, as a share of the largest, below which a direction counts as undetermined."""


def minimum_within_limits(matrix: Array, right: Array, lower: Array, upper: Array) -> Array:
    """Return the x (n,) between two limits that minimises x matrix x / 2 - right x.

    The matrix is scaled to a diagonal of ones. Where it leaves a direction undetermined, x is the shortest of the
    scaled solutions. A value that was put at a limit is released where that lowers the function (bounded-variable
    least squares: Stark and Parker, Computational Statistics 10, 1995).

    Args:
        matrix: (n, n) symmetric, positive semi-definite.
        right: (n,) right-hand side.
        lower: (n,) lowest values, which may be infinite.
        upper: (n,) highest values, each above the lowest.
    """
    if not len(right):
        return np.zeros(0)
    diagonal = np.diag(matrix)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    eigenvalues, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    kept = eigenvalues > UNDETERMINED * max(eigenvalues[-1], np.finfo(float).tiny)
    free = (vectors[:, kept] / eigenvalues[kept]) @ (vectors[:, kept].T @ (right * scale)) * scale
    if np.all((free >= lower) & (free <= upper)):
        return np.asarray(free)
    # A square root of the matrix makes a least-squares problem of the quadratic function.
    root = np.sqrt(eigenvalues[kept])
    rows, target = root[:, None] * vectors[:, kept].T, (vectors[:, kept].T @ (right * scale)) / root
    solution = lsq_linear(rows, target, (lower / scale, upper / scale), method="bvls").x
    return np.asarray(np.clip(solution * scale, lower, upper))
