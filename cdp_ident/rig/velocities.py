# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Velocities of joints whose positions are measured: of a parabola through the last of them."""

from collections import deque
from collections.abc import Sequence

import numpy as np

_FEWEST = 4
"""Samples: a parabola through three is a difference of raw values."""


class Velocities:
    """Estimates the velocity at each sample by least squares (Savitzky and Golay 1964, at the window's end).

    Its lag is none for constant acceleration; its noise is that of the positions times about sqrt(192 / n) / window.
    """

    def __init__(self, window: float) -> None:
        """Use the samples of the last `window` [s]."""
        self._window_ns = round(window * 1e9)
        self._samples: deque[tuple[int, Sequence[float]]] = deque()

    def update(self, stamp_ns: int, positions: Sequence[float]) -> Sequence[float]:
        """Take the next positions; return their velocities, none while fewer than four samples are in the window."""
        samples = self._samples
        if samples and stamp_ns <= samples[-1][0]:
            samples.clear()  # time went back
        samples.append((stamp_ns, positions))
        while samples[0][0] < stamp_ns - self._window_ns:
            samples.popleft()
        if len(samples) < _FEWEST:
            return ()
        times = np.array([stamp - stamp_ns for stamp, _ in samples]) * (1.0 / self._window_ns)
        values = np.array([position for _, position in samples])
        coefficients = np.linalg.lstsq(np.vander(times, 3), values, rcond=None)[0]
        return tuple((coefficients[1] * (1e9 / self._window_ns)).tolist())
