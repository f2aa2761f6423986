# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Known weights clamped to the rods: what they add to the pendulum's inertias and moments.

A free swing shows everything over A22. A weight adds so many kg m^2 of its own, so that trials with different weights
show A22 itself.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Rod = Literal["inner", "outer"]
ErrorOf = tuple[Literal["mass", "place"], Rod | None, float]
"""What of a weight may be wrong: a mass [kg], wherever it is, or a place on a rod [m]."""

RODS: tuple[Rod, ...] = get_args(Rod)
INERTIA = 0
"""Where A22 stands in what weights add; the numerators of the base parameters follow."""
_A22, _A23, _A33, _A1 = range(4)
_NUMBERS = 6


@dataclass(frozen=True)
class Weight:
    """A weight that is clamped to a rod, and how well it is known."""

    rod: Rod
    mass: float
    """[kg]"""
    place: float
    """Distance of its centre of mass from its rod's own joint, along the rod [m]."""
    inertia: float = 0.0
    """Its moment of inertia about its own centre of mass [kg m^2]; of a small weight next to nothing."""
    mass_std: float = 0.0
    """Standard deviation of the mass [kg]."""
    place_std: float = 0.0
    """Standard deviation of the place [m]."""

    def added(self, length: float) -> Array:
        """Return what it adds (6,) to A22 and to A23, A33, a1, c1 and c2, for the length L [m]."""
        m, r = self.mass, self.place
        if self.rod == "inner":
            return _numbers(m * r**2 + self.inertia, a1=m * r)
        return _numbers(m * length**2, m * length * r, m * r**2 + self.inertia, m * length)

    def by_length(self, length: float) -> Array:
        """Return the derivative (6,) of what it adds by L."""
        if self.rod == "inner":
            return _numbers(0.0)
        return _numbers(2.0 * self.mass * length, self.mass * self.place, 0.0, self.mass)

    @property
    def errors(self) -> tuple[ErrorOf, ...]:
        """What of it may be wrong.

        Weights of the same mass are taken for one, and what is clamped to a rod at the same place for clamped once: in
        all trials such have the same error.
        """
        of_mass: tuple[ErrorOf, ...] = (("mass", None, self.mass),) if self.mass_std > 0.0 else ()
        return (*of_mass, ("place", self.rod, self.place)) if self.place_std > 0.0 else of_mass

    def with_errors(self, errors: Mapping[ErrorOf, float]) -> "Weight":
        """Return it as it is where mass and place are off by so many of their standard deviations."""
        mass, place = errors.get(("mass", None, self.mass), 0.0), errors.get(("place", self.rod, self.place), 0.0)
        return replace(self, mass=self.mass + mass * self.mass_std, place=self.place + place * self.place_std)

    def by_error(self, error: ErrorOf, length: float) -> Array:
        """Return the derivative (6,) of what it adds by one of its errors, in standard deviations."""
        m, r = self.mass, self.place
        if error[0] == "mass":
            numbers = (r**2, 0.0, 0.0, r) if self.rod == "inner" else (length**2, length * r, r**2, length)
            return self.mass_std * _numbers(*numbers)
        numbers = (2.0 * m * r, 0.0, 0.0, m) if self.rod == "inner" else (0.0, m * length, 2.0 * m * r, 0.0)
        return self.place_std * _numbers(*numbers)


def added_by(weights: Iterable[Weight], length: float) -> Array:
    """Return what weights add (6,) to A22 and to A23, A33, a1, c1 and c2, for the length L [m]."""
    return sum((weight.added(length) for weight in weights), np.zeros(_NUMBERS))


def mass_beyond(weights: Sequence[Weight], joint: str) -> float:
    """Return the mass of the weights [kg] that a joint carries: the outer one those on the outer rod, others all."""
    return sum(weight.mass for weight in weights if joint != "outer" or weight.rod == "outer")


def _numbers(A22: float, A23: float = 0.0, A33: float = 0.0, a1: float = 0.0) -> Array:
    numbers = np.zeros(_NUMBERS)
    numbers[[_A22, _A23, _A33, _A1]] = A22, A23, A33, a1
    return numbers
