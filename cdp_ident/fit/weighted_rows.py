"""The rows of a least-squares problem, whitened and weighted, and their normal equations (compiled)."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from cdp_ident.machine.compilation import compiled, part
from cdp_ident.model.layout import VECTOR

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


_ROWS = 8
"""So many rows are multiplied at a time, of half as many samples: a sum is loaded and stored once for all of them."""
ROOM = 264
"""Room for a row and its residual, an odd number of cache lines; wider rows are multiplied by the linear algebra
library, which is as fast then."""
_1, _2, _3, _4, _5, _6, _7 = (np.uint64(ROOM * row) for row in range(1, _ROWS))


@dataclass(frozen=True)
class WeightedRows:
    """Two rows of each sample of some windows, and the normal equations of each window."""

    residuals: Array
    """(samples, 2) measured less simulated angles, whitened [rad]."""
    sensitivities: Array
    """(samples, 2, columns) derivatives of the simulated angles, whitened."""
    weights: Array
    """(samples, 2) weight of each residual (Huber)."""
    normal: Array
    """(windows, columns, columns) J^T W J of each window."""
    right: Array
    """(windows, columns) J^T W r of each window."""
    costs: Array
    """(windows,) what each window's residuals cost [rad^2]."""

    @classmethod
    def of(
        cls,
        measured: Array,
        simulated: Array,
        derivatives: Array,
        columns: Indices,
        whitening: Array,
        bounds: Indices,
        limit: float,
    ) -> "WeightedRows":
        """Make them.

        Args:
            measured: (samples, 2) angles [rad].
            simulated: (samples, 2) angles [rad].
            derivatives: (samples, 2, d) of the simulated angles.
            columns: (columns,) which of these are wanted.
            whitening: (samples, 2, 2) matrix that makes a sample's errors independent and of equal size.
            bounds: (windows + 1,) where each window's samples begin, and the last one's end.
            limit: residuals beyond it cost their absolute value only [rad].
        """
        samples, windows, size = len(measured), len(bounds) - 1, len(columns)
        residuals, weights = np.empty((2, samples, 2))
        sensitivities = np.empty((samples, 2, size))
        normal, right, costs = np.empty((windows, size, size)), np.empty((windows, size)), np.empty(windows)
        # The residual is the last column, so that its products are there as well.
        width = -(-(size + 1) // VECTOR) * VECTOR
        _weighted_rows(
            measured, simulated, derivatives, columns, whitening, bounds, limit, np.uint64(width), residuals,
            sensitivities, weights, normal, right, costs,
        )  # fmt: skip
        if width > ROOM:
            for window, (first, end) in enumerate(pairwise(bounds.tolist())):
                rows = sensitivities[first:end].reshape(-1, size)
                weighted = rows * weights[first:end].reshape(-1, 1)
                normal[window], right[window] = weighted.T @ rows, weighted.T @ residuals[first:end].ravel()
        return cls(residuals, sensitivities, weights, normal, right, costs)


@compiled
def _weighted_rows(
    measured, simulated, derivatives, columns, whitening, bounds, limit, width, residuals, sensitivities, weights,
    normal, right, costs,
):  # fmt: skip
    # The rows of some samples are at fixed distances in one array, and the sums of their products in another: only so
    # does the compiler see that these do not overlap, and vectorises the loop over them. For the same reason indices
    # are unsigned.
    size, multiplies = np.uint64(len(columns)), width <= np.uint64(ROOM)
    weight, rows = np.zeros(_ROWS), np.zeros(_ROWS * ROOM)
    sums = np.empty(np.int64(size * width) if multiplies else 0)
    for w in range(len(costs)):
        for k in range(len(sums)):
            sums[k] = 0.0
        cost, filled = 0.0, np.uint64(0)
        for j in range(bounds[w], bounds[w + 1]):
            a, b, c, d = whitening[j, 0, 0], whitening[j, 0, 1], whitening[j, 1, 0], whitening[j, 1, 1]
            off1, off2 = measured[j, 0] - simulated[j, 0], measured[j, 1] - simulated[j, 1]
            residuals[j, 0], residuals[j, 1] = a * off1 + b * off2, c * off1 + d * off2
            for r in range(2):
                residual, large = residuals[j, r], abs(residuals[j, r])
                weights[j, r] = limit / large if large > limit else 1.0
                cost += limit * (2.0 * large - limit) if large > limit else residual * residual
            for k in range(size):
                by1, by2 = derivatives[j, 0, columns[k]], derivatives[j, 1, columns[k]]
                sensitivities[j, 0, k], sensitivities[j, 1, k] = a * by1 + b * by2, c * by1 + d * by2
            if multiplies:
                for r in range(2):
                    row = filled * np.uint64(ROOM)
                    for k in range(size):
                        rows[row + k] = sensitivities[j, r, k]
                    rows[row + size], weight[filled] = residuals[j, r], weights[j, r]
                    filled += np.uint64(1)
                if filled == np.uint64(_ROWS):
                    _add_products(rows, weight, size, width, sums)
                    filled = np.uint64(0)
        costs[w] = cost
        if multiplies:
            # What is left of earlier samples counts no more.
            for r in range(filled, np.uint64(_ROWS)):
                weight[r] = 0.0
            _add_products(rows, weight, size, width, sums)
            for k in range(size):
                right[w, k] = sums[k * width + size]
                for i in range(k, size):
                    normal[w, k, i], normal[w, i, k] = sums[k * width + i], sums[k * width + i]


@part
def _add_products(rows, weight, size, width, sums):
    """Add the products of some weighted rows with themselves: the upper triangle, and some elements beside it."""
    for k in range(size):
        f0, f1, f2, f3 = (
            weight[0] * rows[k], weight[1] * rows[_1 + k], weight[2] * rows[_2 + k], weight[3] * rows[_3 + k]
        )  # fmt: skip
        f4, f5, f6, f7 = (
            weight[4] * rows[_4 + k], weight[5] * rows[_5 + k], weight[6] * rows[_6 + k], weight[7] * rows[_7 + k]
        )  # fmt: skip
        # From the beginning of the vector on that the diagonal is in.
        first = k - k % np.uint64(VECTOR)
        total = k * width
        for i in range(first, width):
            sums[total + i] += (f0 * rows[i] + f1 * rows[_1 + i] + f2 * rows[_2 + i] + f3 * rows[_3 + i]) + (
                f4 * rows[_4 + i] + f5 * rows[_5 + i] + f6 * rows[_6 + i] + f7 * rows[_7 + i]
            )
