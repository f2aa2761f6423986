# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials cut into windows, each simulated from an initial state of its own.

A double pendulum is chaotic: beyond a few seconds no simulation from one initial state follows an energetic trial,
whatever its parameters. Windows are two small swings long, or shorter where the motion is fast.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.model.steps import Times
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid, interpolated
from cdp_ident.model.weights import Weight
from cdp_ident.trial.kinematics import local_motion
from cdp_ident.trial.trial import Trial

DEFAULT_WINDOW = 2.5
"""Length of a window [s]."""
NEAR_STEPS = 10
"""Samples within so many steps of the integrator, 0.05 s of the paper's rig, show where a window or a piece begins; and
pieces are twice as long, half a time unit. With half or twice as many steps in these errors are the same; with four
times as many, two of some 2000 windows were lost."""
_GAP = 2.0
"""Samples are missing where none comes for so many usual steps."""
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
FEWEST_SAMPLES = 12
"""Least samples in a window: it determines its initial state (four numbers) from two angles a sample, and needs some
more."""


@dataclass(frozen=True)
class Window:
    """A stretch of a trial that is simulated from one initial state."""

    trial: int
    """Which trial it is of."""
    first: int
    """Index of its first sample in the trial."""
    begin: float
    """Time of that sample in the trial [s]."""
    time: Array
    """(n,) times of its samples since then [s]."""
    theta: Array
    """(n, 2) measured angles theta1, theta2 [rad]."""
    grid: TimeGrid
    """The integrator's steps; time 0 is the window's first sample."""
    u: Array
    """(2 steps + 1,) cart's acceleration at the half steps [m/s^2]."""
    start: Array
    """(4,) state at time 0, estimated from the measured angles: theta1, theta2 [rad], omega1, omega2 [rad/s]."""
    drive: Array | None = None
    """(2 steps + 1, 2) motors' torques in both joints at the half steps [N m]; None where there are none."""
    time_std: float = 0.0
    """Relative standard deviation of its trial's unit of time."""
    weights: tuple[Weight, ...] = ()
    """The known weights that were clamped to the rods in its trial."""

    @property
    def duration(self) -> float:
        """Time from its first to its last sample, in whole steps of the integrator [s]."""
        return self.grid.steps * self.grid.step

    @property
    def cart_acceleration(self) -> Array:
        """(n,) the cart's acceleration u at its samples [m/s^2]."""
        return np.interp(self.time, self.grid.half_step_times(), self.u)

    @property
    def torques(self) -> Array | None:
        """(n, 2) the motors' torques at its samples [N m]; None where there are none."""
        return None if self.drive is None else interpolated(self.time, self.grid.half_step_times(), self.drive)

    @property
    def samples(self) -> slice:
        """Where its samples are in the trial."""
        return slice(self.first, self.first + len(self.theta))

    def in_pieces(self, steps: int | None = None) -> Times:
        """Return when its motion is computed, in pieces of so many steps of the integrator; in one by default."""
        grid, drive = self.grid, np.zeros((0, 2)) if self.drive is None else self.drive
        edges = np.append(np.arange(0, grid.steps, steps or grid.steps), grid.steps)
        samples_at, firsts = grid.first_sample[edges], edges[:-1]
        # Each piece has its own beginning and end among the half steps.
        halves = np.arange(2 * grid.steps + len(firsts)) - np.repeat(np.arange(len(firsts)), 2 * np.diff(edges) + 1)
        return Times(
            begin=self.begin + firsts * grid.step,
            step=np.full(len(firsts), grid.step),
            steps_at=edges,
            samples_at=samples_at,
            place=grid.place - np.repeat(firsts, np.diff(samples_at)),
            u=self.u[halves],
            drive=drive[halves] if len(drive) else drive,
        )

    def states(self, at: Array) -> Array:
        """Return the rods' states (n, 4) at times (n,) since its beginning [s], as the samples near them show these."""
        return np.concatenate(local_motion(self.time, self.theta, at, NEAR_STEPS * self.grid.step), axis=1)


def cut_into_windows(trials: Sequence[Trial], duration: float = DEFAULT_WINDOW) -> list[Window]:
    """Cut trials into windows of about `duration` [s], equally long within a stretch of a trial, without overlap."""
    windows = []
    for index, trial in enumerate(trials):
        for first, last in trial.bounds:
            windows += cut_at(trial, index, evenly(trial, first, last, duration))
    return windows


def shared(windows: Sequence[Window], enough: float) -> list[Window]:
    """Return a share of windows that is spread evenly and lasts for enough [s], or all; see `share_of`."""
    return [windows[index] for index in share_of([window.duration for window in windows], enough)]


def without_gaps(time: Array) -> list[tuple[int, int]]:
    """Return the first sample and the end of each stretch of samples, taken at times (n,), in which none is missing."""
    steps = np.diff(time)
    return list(pairwise((0, *(np.flatnonzero(steps > _GAP * np.median(steps)) + 1).tolist(), len(time))))


def evenly(trial: Trial, first: int, last: int, duration: float) -> list[int]:
    """Return the first samples of equally long windows of about `duration` [s] in a stretch, and the one after it."""
    lasts = float(trial.time[last - 1] - trial.time[first])
    count = max(1, round(lasts / duration))
    places = trial.time[first] + lasts * np.arange(1, count) / count
    return [first, *(first + np.searchsorted(trial.time[first:last], places)).tolist(), last]


def beginning_of(trial: Trial, index: int, duration: float, step: float = DEFAULT_STEP) -> Window:
    """Return the first `duration` [s] of a trial, or its first few samples where these last longer, as a window."""
    samples = int(np.searchsorted(trial.time, trial.time[0] + duration, side="right"))
    return cut_at(trial, index, [0, max(samples, FEWEST_SAMPLES)], step)[0]


def cut_at(trial: Trial, index: int, bounds: Sequence[int], step: float = DEFAULT_STEP) -> list[Window]:
    """Cut a trial into windows at samples.

    Initial states are estimated from the samples of their own window alone, so that a window that is kept out of a fit
    does not affect it. Pieces with too few samples are left out.

    Args:
        trial: what is cut.
        index: which trial it is.
        bounds: the first sample of each window, and the one after the last.
        step: of the integrator [s].
    """
    windows = []
    acceleration = trial.cart_acceleration
    for first, last in pairwise(bounds):
        if last - first < FEWEST_SAMPLES:
            continue
        time = trial.time[first:last] - trial.time[first]
        theta = np.ascontiguousarray(trial.theta[first:last])
        grid = TimeGrid.over(time, step)
        half_steps = grid.half_step_times()
        u = np.zeros(len(half_steps)) if acceleration is None else np.interp(half_steps, time, acceleration[first:last])
        angles, velocities = local_motion(time, theta, np.zeros(1), NEAR_STEPS * step)
        start = np.concatenate([angles[0], velocities[0]])
        begin = float(trial.time[first])
        time_std = trial.clock.std if trial.clock else 0.0
        windows.append(
            Window(
                trial=index,
                first=int(first),
                begin=begin,
                time=time,
                theta=theta,
                grid=grid,
                u=u,
                drive=grid.at_half_steps(time, None if trial.torques is None else trial.torques[first:last]),
                start=start,
                time_std=time_std,
                weights=trial.weights,
            )
        )
    return windows


def share_of(durations: Sequence[float], enough: float) -> tuple[int, ...]:
    """Return the indices of pieces, ascending, that are spread evenly over all and last for enough [s] together.

    They are all pieces where these last no longer, and at least one. Looking for effects takes hundreds of fits, and of
    what an hour shows, a minute or two show most. The golden ratio's multiples, modulo one, are nowhere dense, nowhere
    sparse, and never in step with anything that repeats, as the beginnings of trials do (Weyl, Math. Ann. 77, 1916).
    """
    order = np.argsort(np.arange(len(durations)) * _GOLDEN % 1.0, kind="stable")
    motion = np.cumsum(np.asarray(durations)[order])
    count = len(durations) if motion[-1] <= enough else max(int(np.searchsorted(motion, enough)), 1)
    return tuple(sorted(order[:count].tolist()))
