"""What gives a motion, and several of these laid out end to end for compiled code."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.torques import NO_TORQUES, Torques

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Number = TypeVar("Number", np.float64, np.int64)


@dataclass(frozen=True)
class InitialValueProblem:
    """What gives one motion: see `trajectory`."""

    coefficients: Array
    start: Array
    grid: TimeGrid
    u: Array
    torques: Torques = NO_TORQUES
    begin: float = 0.0


@dataclass(frozen=True)
class EndToEnd:
    """Problems whose inputs, steps and samples are end to end in one array each.

    Compiled code takes arrays that may be written to: processes that keep code for several kinds of arrays at the same
    time could take one's for the other's.
    """

    problems: Sequence[InitialValueProblem]

    @property
    def coefficients(self) -> Array:
        """(motions, 7) `COEFFICIENTS` of each."""
        return np.array([problem.coefficients for problem in self.problems])

    def starts(self, states: int) -> Array:
        """Return the states (motions, states) at the beginning; what is left out at their ends is zero."""
        starts = np.zeros((len(self.problems), states))
        for row, problem in zip(starts, self.problems, strict=True):
            given = problem.start[:states]
            row[: len(given)] = given
        return starts

    @property
    def begins(self) -> Array:
        """(motions,) time in the trial at the beginning [s]."""
        return np.array([problem.begin for problem in self.problems], dtype=np.float64)

    @cached_property
    def grids(self) -> tuple[Array, Array, Indices, Indices, Indices, Array, Indices]:
        """The steps' lengths (motions,) [s]; of all motions u, first samples and places.

        Each of these three is followed by where a motion's own begin (motions + 1,), and the last one's end.
        """
        grids = [problem.grid for problem in self.problems]
        u, of_u = _joined([problem.u for problem in self.problems])
        first_sample, of_steps = _joined([grid.first_sample for grid in grids])
        place, of_samples = _joined([grid.place for grid in grids])
        return np.array([grid.step for grid in grids]), u, of_u, first_sample, of_steps, place, of_samples

    def mark_uncomputed(self, states: Array, derivatives: Array, computed: Indices) -> None:
        """Let states and derivatives of all samples be no numbers from where on a motion could not be computed.

        Args:
            states: (samples, states) of all motions.
            derivatives: (samples, …) of all motions.
            computed: (motions,) how many of its samples each motion reaches.
        """
        bounds = self.grids[-1]
        ends = bounds[1:]
        if np.all(computed == np.diff(bounds)) and np.all(np.isfinite(states[ends - 1])):
            return
        for (first, end), reached in zip(pairwise(bounds.tolist()), computed.tolist(), strict=True):
            _mark_uncomputed(states[first:end], derivatives[first:end], reached)


def _joined(arrays: Sequence[npt.NDArray[Number]]) -> tuple[npt.NDArray[Number], Indices]:
    """Return arrays end to end, and where each begins and the last one ends."""
    return np.concatenate(arrays), np.array([0, *accumulate(map(len, arrays))])


def _mark_uncomputed(states: Array, derivatives: Array, computed: int) -> None:
    states[computed:] = np.nan
    if not np.all(np.isfinite(states[-1])):
        # Compiled code cannot tell numbers that are none: it may have gone on with them.
        computed = int(np.argmin(np.isfinite(states).all(axis=1)))
        states[computed:], derivatives[computed:] = np.nan, np.nan
