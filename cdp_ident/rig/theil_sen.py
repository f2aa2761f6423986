# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The slope of a line through points of which some are far off: the median of the slopes between all pairs."""

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def median_slope(x: Array, y: Array) -> tuple[float, float, float]:
    """Return the slope of y (n,) over x (n,), and the ends of the interval of one standard deviation about it.

    The slope is Theil's (1950). The interval is Sen's (J. Am. Stat. Assoc. 63, 1968): Kendall's rank correlation of
    what the line leaves is none within it. `scipy.stats.theilslopes` gives the same, but to load it takes longer than
    all else of a driver, whose samples wait meanwhile.

    Args:
        x: strictly increasing, two at least.
        y: among which there may be equal ones.
    """
    earlier, later = np.triu_indices(len(x), 1)
    slopes = np.sort((y[later] - y[earlier]) / (x[later] - x[earlier]))
    _, alike = np.unique(y, return_counts=True)
    # The variance of Kendall's score, which values that are alike diminish.
    whole, *parts = (count * (count - 1) * (2 * count + 5) / 18.0 for count in (len(y), *alike.tolist()))
    std = math.sqrt(max(whole - sum(parts), 0.0))
    low = max(round((len(slopes) - std) / 2.0) - 1, 0)
    high = min(round((len(slopes) + std) / 2.0), len(slopes) - 1)
    return float(np.median(slopes)), float(slopes[low]), float(slopes[high])
