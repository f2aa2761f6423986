"""How long windows are: as long as the motion is predictable from their beginning.

A trial is energetic at first and calm at its end. Windows that are short enough for its beginning would not show slow
effects later on; windows that suit its end would be too long to be simulated at its beginning.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.predictability import predictability
from cdp_ident.fit.scales import Scales, smooth_on_grid
from cdp_ident.fit.smoothing import FEWEST
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]
Lengths = Callable[[float], float]
"""Length of the window that begins at a time in a trial [s]."""

_ROUND_UP = 1.25
"""A window may be longer by this factor, to take in the end of a stretch."""


def predictable_lengths(
    trial: Trial, scales: Scales, groups: Array | None, length: float, gravity: float, noise: Array
) -> Lengths:
    """Return for how long a trial's motion is predictable from each time.

    Args:
        trial: what is cut.
        scales: of the rig.
        groups: (5,) rough values of the base parameters; without them windows have their greatest length.
        length: L [m].
        gravity: g [m/s^2].
        noise: (2,) standard deviation of the noise of theta1 and theta2 [rad].
    """
    if groups is None:
        return lambda time: scales.window
    begins, lasts = [], []
    for (first, last), stretch in zip(trial.bounds, trial.stretches, strict=True):
        if last - first < FEWEST:
            continue
        motion = smooth_on_grid(stretch.time, stretch.theta, scales.time_unit)
        spacing = float(np.median(np.diff(stretch.time)))
        half_width, longest = scales.half_width, scales.longest_window
        found = predictability(motion, groups, length, gravity, noise, spacing, half_width, longest)
        begins.append(float(trial.time[first]))
        lasts.append(found)
    if not begins:
        return lambda time: scales.window

    def length_at(time: float) -> float:
        at = max(int(np.searchsorted(begins, time, side="right")) - 1, 0)
        return max(lasts[at].at(time - begins[at]), scales.shortest_piece)

    return length_at


def window_bounds(trial: Trial, length_at: Lengths, longest: float = np.inf) -> list[list[int]]:
    """Return for each stretch of a trial the first samples of its windows, and the one after the last.

    Args:
        trial: what is cut.
        length_at: length of the window that begins at a time [s].
        longest: no window is longer [s].
    """
    cut = []
    for first, last in trial.bounds:
        time = trial.time[first:last]
        bounds = [first]
        while True:
            begin, left = float(trial.time[bounds[-1]]), float(time[-1] - trial.time[bounds[-1]])
            lasts = min(length_at(begin), longest)
            if left <= _ROUND_UP * lasts:
                break
            following = first + int(np.searchsorted(time, begin + min(lasts, left / 2.0)))
            bounds.append(max(following, bounds[-1] + 1))
        cut.append([*bounds, last])
    return cut
