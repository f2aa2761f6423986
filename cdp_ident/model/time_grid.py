# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The integrator's own steps, and how to read a motion at measurement times that are not on them."""

from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.errors import OptionError
from cdp_ident.model.runge_kutta import hermite

DEFAULT_STEP = 0.005
"""The paper's step of the Runge-Kutta method [s] (Section 4.2)."""


@dataclass(frozen=True)
class TimeGrid:
    """Fixed steps from time 0 on, and where among them each measurement lies.

    A motion between two steps is the cubic Hermite polynomial through both ends' angles and velocities, whose error
    of order step^4 stays below the integrator's own.
    """

    step: float
    """[s]"""
    steps: int
    place: Array
    """(n,) when each measurement is made, in steps."""

    @classmethod
    def over(cls, times: Array, step: float = DEFAULT_STEP) -> "TimeGrid":
        """Lay the grid over measurement times (n,) [s]. Raises `OptionError` where these do not ascend from 0 on."""
        times = np.ascontiguousarray(times, dtype=float)
        if not 0.0 < step < np.inf:
            raise OptionError(f"the step of the integrator is {step} s; it must be positive (0.005 s is usual)")
        if times.ndim != 1 or len(times) == 0 or not np.all(np.isfinite(times)):
            raise OptionError("a simulation needs a list of finite times at which to give the motion")
        if times[0] < 0.0 or np.any(np.diff(times) < 0):
            raise OptionError("the times of a simulation must ascend and not lie before its start at 0 s")
        place = times / step
        return cls(float(step), int(_index(place)[-1]) + 1, place)

    @property
    def first_sample(self) -> Indices:
        """(steps + 1,) index of the first measurement in each step; the last one is the number of measurements."""
        return np.searchsorted(_index(self.place), np.arange(self.steps + 1)).astype(np.int64)

    @property
    def weights(self) -> Array:
        """(n, 4) what each measurement is of the values at its step's beginning and end and of the derivatives there.

        The last two contain the step [s].
        """
        return np.stack(hermite(self.place - _index(self.place), self.step), axis=1)

    def half_step_times(self) -> Array:
        """Return the times (2 steps + 1,) [s] at which the integrator looks at an input."""
        return np.asarray(np.arange(2 * self.steps + 1) * (0.5 * self.step), dtype=float)

    def at_half_steps(self, times: Array, torques: Array | None, since: float = 0.0) -> Array | None:
        """Return torques (n, 2) that are known at times (n,) [s] at the half steps; the grid begins at `since` [s]."""
        if torques is None:
            return None
        return interpolated(self.half_step_times() + since, times, torques)


def interpolated(at: Array, times: Array, values: Array) -> Array:
    """Return values (n, k) at times (n,) at others (m,): (m, k), by cubics whose slopes are those between neighbours.

    Beyond the ends they hold.
    """
    within = np.clip(at, *times[[0, -1]])
    return np.column_stack([between(times, of, np.gradient(of, times), within) for of in values.T])


def between(stamps: Array, values: Array, slopes: Array, at: Array) -> Array:
    """Return values (m,) at times between stamps (n,) [s], at which they and their slopes (n,) are known.

    It is Hermite's cubic. To load scipy's takes a third of the time that an emulator takes to start.
    """
    before = np.clip(np.searchsorted(stamps, at, side="right") - 1, 0, len(stamps) - 2)
    step = stamps[before + 1] - stamps[before]
    old, new, first, last = hermite((at - stamps[before]) / step, step)
    return np.asarray(
        old * values[before] + new * values[before + 1] + first * slopes[before] + last * slopes[before + 1]
    )


def _index(place: Array) -> Indices:
    """Return in which step each of some places lies; one at the end of a step, give or take rounding, is in that."""
    return np.maximum(np.ceil(place - 1e-9).astype(np.int64) - 1, 0)
