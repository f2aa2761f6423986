# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The starts that a hand can lead both rods to, surveyed for the best one."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.design.candidate_trial import CandidateTrial
from cdp_ident.errors import IdentificationError
from cdp_ident.machine.parallel import parallel_for, parallel_map
from cdp_ident.model.weights import Weight

Array = npt.NDArray[np.float64]

HAND = 5.0
"""By which a hand may miss an angle that it leads a rod to [degrees]."""
_FEW = 3
"""Angles of which none is left out."""
_FINALISTS = 5
"""So many of the best starts are judged by what comes of them where the hand misses."""


@dataclass(frozen=True)
class Grid:
    """Starts at which both rods are held, by their angles from hanging, positive towards +x."""

    inner: Array
    """(n,) of the inner rod [rad]."""
    outer: Array
    """(m,) of the outer rod [rad]."""

    @classmethod
    def of(cls, spacing: float, most_inner: float = 180.0, most_outer: float = 180.0) -> "Grid":
        """Lay a grid [degrees]; no rod is led further from hanging than is said."""
        return cls(_angles(spacing, most_inner), _angles(spacing, most_outer))

    @property
    def thinned(self) -> "Grid":
        """The grid with every second angle, hanging among them; with all, where they are few."""
        return Grid(_every_second(self.inner), _every_second(self.outer))

    def trial(self, inner: int, outer: int, weights: tuple[Weight, ...] = ()) -> CandidateTrial:
        """Return the trial that begins at a place of the grid."""
        return _from_hanging(float(self.inner[inner]), float(self.outer[outer]), weights)


def _angles(spacing: float, most: float) -> Array:
    count = int(most / spacing + 1e-9)
    # Half a turn to one side is half a turn to the other.
    return np.radians(spacing * np.arange(-count + (count * spacing >= 180.0), count + 1))


def _every_second(angles: Array) -> Array:
    hanging = int(np.argmin(np.abs(angles)))
    return angles[hanging % 2 :: 2] if len(angles) > _FEW else angles


def _from_hanging(inner: float, outer: float, weights: tuple[Weight, ...]) -> CandidateTrial:
    return CandidateTrial(np.pi + inner, np.pi + outer, weights)


@dataclass(frozen=True)
class Survey:
    """What a criterion makes of every start, and the one to take."""

    grid: Grid
    losses: Array
    """(inner, outer) at each start, smaller is better; infinite where the motion cannot be computed."""
    inner: float
    """The start to take: of the inner rod, from hanging [rad]."""
    outer: float
    """Of the outer rod [rad]."""
    expected: float
    """Its loss, as the median over what the hand may miss it by."""
    worst: float
    """The largest of these."""
    weights: tuple[Weight, ...] = ()
    """On the rods, at each start."""
    unloaded: "Survey | None" = None
    """The same without a weight, where it was asked for."""

    @property
    def trial(self) -> CandidateTrial:
        """The trial that begins there."""
        return _from_hanging(self.inner, self.outer, self.weights)


def survey(loss: Callable[[CandidateTrial], float], grid: Grid, weights: tuple[Weight, ...] = ()) -> Survey:
    """Return which start has the smallest loss, also where the hand misses it by HAND; the rods have weights.

    A double pendulum is let go from nearby starts to quite different motions: what is best at a point and nowhere
    around it is no advice.

    Raises:
        IdentificationError: no start has a loss that can be computed.
    """
    losses = np.empty((len(grid.inner), len(grid.outer)))

    def work(first: int, last: int) -> None:
        for place in range(first, last):
            inner, outer = divmod(place, len(grid.outer))
            losses[inner, outer] = loss(grid.trial(inner, outer, weights))

    parallel_for(work, losses.size)
    if not np.any(np.isfinite(losses)):
        raise IdentificationError("from no start can the fitted model's motion be computed: identify again")
    places = [
        divmod(int(place), len(grid.outer)) for place in np.argsort(losses, axis=None, kind="stable")[:_FINALISTS]
    ]
    misses = [(a, b) for a in np.radians([-HAND, HAND]) for b in np.radians([-HAND, HAND])]
    missed = [
        _from_hanging(float(grid.inner[i]) + a, float(grid.outer[j]) + b, weights) for i, j in places for a, b in misses
    ]
    of_missed = np.array(list(parallel_map(loss, missed))).reshape(len(places), len(misses))
    finalists = []
    for (i, j), near in zip(places, of_missed.tolist(), strict=True):
        around = [float(losses[i, j]), *near]
        finalists.append((float(np.median(around)), max(around), float(grid.inner[i]), float(grid.outer[j])))
    expected, worst, inner, outer = min(finalists)
    return Survey(grid, losses, inner, outer, expected, worst, weights)
