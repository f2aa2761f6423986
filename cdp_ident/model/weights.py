# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Known weights clamped to the rods: what they add to the pendulum's inertias and moments, and how they are written.

A free swing shows everything over A22. A weight adds so many kg m^2 of its own, so that trials with different weights
show A22 itself. People and files give them as `added.<rod>` and `added_std.<rod>`, each a list of numbers.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import OptionError
from cdp_ident.user_input import number, quoted, refuse_unknown

Rod = Literal["inner", "outer"]
ErrorOf = tuple[Literal["mass", "place"], Rod | None, float]
"""What of a weight may be wrong: a mass [kg], wherever it is, or a place on a rod [m]."""

RODS: tuple[Rod, ...] = get_args(Rod)
INERTIA = 0
"""Where A22 stands in what weights add; the numerators of the base parameters follow."""
_NUMBERS = 6

ADDED, ADDED_STD = "added", "added_std"
NAMES = tuple(f"{what}.{rod}" for what in (ADDED, ADDED_STD) for rod in RODS)
NOTHING = (0.0, 0.0)
"""What stands for no weight, where nothing cannot be written."""
DESCRIPTIONS = {
    ADDED: "weight on the {rod} rod: mass [kg], distance of its centre from the rod's own joint [m] and, if it "
    "matters, its own moment of inertia [kg m^2]; a mass of 0 is no weight",
    ADDED_STD: "standard deviations of the weight on the {rod} rod: mass [kg], distance [m]",
}
STANDARD_RELATIVE_STD = 0.01
"""Relative standard deviation of a mass for which none is given."""
STANDARD_PLACE_STD = 1e-3
"""Standard deviation of a place for which none is given [m]."""
_HEAVIEST, _FARTHEST = 1e4, 1e3
_MOST_TIMES_THE_PENDULUM, _MOST_RODS = 10.0, 1.5
"""No weight is heavier than so many pendulums, or further from its joint than so many lengths of its rod."""


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
        mass, r, inertia = self.mass, self.place, self.inertia
        if self.rod == "inner":
            return np.array([mass * r**2 + inertia, 0.0, 0.0, mass * r, 0.0, 0.0])
        return np.array([mass * length**2, mass * length * r, mass * r**2 + inertia, mass * length, 0.0, 0.0])

    def by_length(self, length: float) -> Array:
        """Return the derivative (6,) of what it adds by L: it is quadratic, so that differences are exact."""
        return 0.5 * (self.added(length + 1.0) - self.added(length - 1.0))

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
        if error[0] == "mass":
            return np.asarray(self.mass_std * replace(self, mass=1.0, inertia=0.0).added(length))
        ahead, behind = (replace(self, place=self.place + one).added(length) for one in (1.0, -1.0))
        return np.asarray(0.5 * self.place_std * (ahead - behind))


def added_by(weights: Iterable[Weight], length: float) -> Array:
    """Return what weights add (6,) to A22 and to A23, A33, a1, c1 and c2, for the length L [m]."""
    return sum((weight.added(length) for weight in weights), np.zeros(_NUMBERS))


def mass_beyond(weights: Sequence[Weight], joint: str) -> float:
    """Return the mass of the weights [kg] that a joint carries: the outer one those on the outer rod, others all."""
    return sum(weight.mass for weight in weights if joint != "outer" or weight.rod == "outer")


def weights_of(given: Mapping[str, Any], where: str) -> dict[Rod, Weight | None]:
    """Return the weights that are given by `NAMES`; None for a rod of which is said that it has none.

    Raises `OptionError` where a name is unknown, or a value is not possible; `where` says where it stands.
    """
    refuse_unknown(given, NAMES, f"key of {where}")
    found: dict[Rod, Weight | None] = {}
    for rod in RODS:
        name, name_of_std = f"{ADDED}.{rod}", f"{ADDED_STD}.{rod}"
        if name in given:
            places = f"{where}.{name}", f"{where}.{name_of_std}"
            found[rod] = weight_of(rod, given[name], given.get(name_of_std), *places)
        elif name_of_std in given:
            raise OptionError(f"{where}.{name_of_std} is given, but {where}.{name} is not: give both")
    return found


def weight_of(rod: Rod, added: Any, std: Any, where: str, where_std: str) -> Weight | None:
    """Return the weight that lists of numbers describe, see `DESCRIPTIONS`; None for one of no mass.

    There are usual standard deviations, for None. Raises `OptionError` where a value is not possible; `where` and
    `where_std` say where the lists stand.
    """
    numbers = _checked(added, where, "[mass in kg, place in m] or with the inertia in kg m^2", 3)
    mass, place, inertia = (*numbers, 0.0)[:3]
    std = (STANDARD_RELATIVE_STD * mass, STANDARD_PLACE_STD) if std is None else std
    mass_std, place_std = _checked(std, where_std, "[of the mass in kg, of the place in m]")
    if mass > 0.0 and place == 0.0 and rod == "inner" and inertia == 0.0:
        raise OptionError(f"{where} is {quoted(added)}: a weight in the joint that does not move adds 0")
    return Weight(rod, mass, place, inertia, mass_std, place_std) if mass > 0.0 else None


def settings_of(weights: Iterable[Weight]) -> dict[str, list[float]]:
    """Return weights by `NAMES`, as `weights_of` takes them."""
    settings = {}
    for weight in weights:
        settings[f"{ADDED}.{weight.rod}"] = [weight.mass, weight.place, weight.inertia]
        settings[f"{ADDED_STD}.{weight.rod}"] = [weight.mass_std, weight.place_std]
    return settings


def refuse_misplaced(weight: Weight, length: float, pendulum: float, where: str) -> None:
    """Raise `OptionError` where a weight is far beyond its rod's length [m], or far heavier than the pendulum [kg].

    `where` says where it stands.
    """
    if weight.place > _MOST_RODS * length:
        raise OptionError(f"{where}: {weight.place:g} m is far beyond the rod of {length:g} m; is it in metres?")
    if weight.mass > _MOST_TIMES_THE_PENDULUM * pendulum:
        raise OptionError(
            f"{where}: {weight.mass:g} kg is far heavier than the pendulum of {pendulum:g} kg; is it in kilograms, "
            "and are the nominal masses right?"
        )


def _checked(given: Any, where: str, expected: str, most: int = 2) -> list[float]:
    if not isinstance(given, Sequence) or isinstance(given, str | bytes) or not 2 <= len(given) <= most:
        raise OptionError(f"{where} is {quoted(given)}; expected {expected}")
    return [number(x, where, 0.0, limit) for x, limit in zip(given, (_HEAVIEST, _FARTHEST, _HEAVIEST), strict=False)]
