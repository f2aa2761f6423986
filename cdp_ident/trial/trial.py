# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A trial: one stretch of motion without input, or with a known one, in the angles that the model uses."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.interpolate import make_smoothing_spline

from cdp_ident.arrays import Array, Mask, Rows
from cdp_ident.bag.device_messages import ClockRate
from cdp_ident.model.weights import Weight


@dataclass(frozen=True)
class Trial(Rows):
    """One motion of the pendulum, free or with known inputs, as measured.

    `theta` holds the paper's theta1 (inner rod) and theta2 (outer rod): both absolute, zero upright, pi hanging,
    positive towards +x, continuous. Samples keep the spacing at which they were measured; nothing is resampled.
    """

    name: str
    """What people call it: the bag's name."""
    time: Array
    """(n,) time of each sample since the first one [s], strictly increasing."""
    theta: Array
    """(n, 2) measured angles theta1, theta2 [rad]."""
    cart: Array | None = None
    """(n,) measured cart position x [m], or None where it was not measured: then the cart is taken to be at rest."""
    start: float = 0.0
    """Time of the first sample since the beginning of the bag [s]."""
    notes: tuple[str, ...] = ()
    """What was dropped, cut or noticed on the way from the bag to here, in words, with numbers."""
    clock: ClockRate | None = None
    """How fast the device's clock ran whose times these are, None where they are stamps."""
    breaks: tuple[int, ...] = ()
    """Indices of the first samples after gaps so long that turns of the rods could be lost in them."""
    outliers: tuple[float, ...] = ()
    """When samples were left out as outliers, since the beginning of the bag [s]."""
    weights: tuple[Weight, ...] = ()
    """The known weights that were clamped to the rods."""
    torques: Array | None = None
    """(n, 2) torques of motors in the inner and the outer joint [N m]; None where the joints are free."""

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])

    @cached_property
    def cart_acceleration(self) -> Array | None:
        """The cart's acceleration u at each sample (n,) [m/s^2], or None where the cart is at rest.

        It is the second derivative of a smoothing spline through the measured positions; how smooth is decided by
        generalised cross-validation (Wahba, Spline Models for Observational Data, 1990).
        """
        if self.cart is None or np.ptp(self.cart) == 0.0:
            return None
        return np.asarray(make_smoothing_spline(self.time, self.cart).derivative(2)(self.time))

    @property
    def bounds(self) -> tuple[tuple[int, int], ...]:
        """First sample of each stretch without such gaps, and the one after its last."""
        edges = (0, *self.breaks, len(self.time))
        return tuple(pairwise(edges))

    @property
    def stretches(self) -> tuple["Trial", ...]:
        """The stretches without such gaps, as trials of their own, each beginning at time 0."""
        return tuple(self.part(slice(*bounds)) for bounds in self.bounds) if self.breaks else (self,)

    def part(self, chosen: Mask | slice) -> "Trial":
        """Return some samples, one after the other, as a trial of its own that begins at time 0."""
        taken = self[chosen]
        first, last = (self.start + taken.time[[0, -1]]).tolist()
        outliers = tuple(at for at in self.outliers if first <= at <= last)
        return replace(taken, time=taken.time - taken.time[0], start=first, breaks=(), outliers=outliers)


def joined(stretches: Sequence[Trial]) -> Trial:
    """Return one trial of stretches of one motion, of each of which `start` tells when it began.

    Turns between two of them are taken to be those that the velocities ask for. The names and notes are the first's.
    """
    first = stretches[0]
    times, angles, breaks = [first.time], [first.theta], []
    for before, after in pairwise(stretches):
        breaks.append(sum(map(len, times)))
        gap = after.start - before.start - before.duration
        velocity = (before.theta[-1] - before.theta[-2]) / (before.time[-1] - before.time[-2])
        expected = angles[-1][-1] + velocity * gap
        turns = np.round((expected - after.theta[0]) / (2.0 * np.pi))
        times.append(after.time + after.start - first.start)
        angles.append(after.theta + 2.0 * np.pi * turns)
    carts = [stretch.cart for stretch in stretches if stretch.cart is not None]
    torques = [stretch.torques for stretch in stretches if stretch.torques is not None]
    return replace(
        first,
        time=np.concatenate(times),
        theta=np.concatenate(angles),
        cart=np.concatenate(carts) if carts else None,
        torques=np.concatenate(torques) if torques else None,
        breaks=tuple(breaks),
        outliers=tuple(at for stretch in stretches for at in stretch.outliers),
    )
