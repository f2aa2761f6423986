# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Weights as people and files give them: `added.<rod>` and `added_std.<rod>`, each a list of numbers."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cdp_ident.errors import OptionError
from cdp_ident.model.weights import RODS, Rod, Weight
from cdp_ident.user_input import number, quoted, refuse_unknown

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


def weights_of(given: Mapping[str, Any], where: str) -> dict[Rod, Weight | None]:
    """Return the weights that are given by `NAMES`; None for a rod of which is said that it has none.

    Raises:
        OptionError: a name is unknown, or a value is not possible; `where` says where it stands.
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
    """Return the weight that lists of numbers describe; None for one of no mass.

    Args:
        rod: that has it.
        added: mass [kg], place [m] and, if it matters, inertia [kg m^2].
        std: standard deviations of mass and place; None for the usual ones.
        where: where `added` stands, for messages.
        where_std: where `std` does.

    Raises:
        OptionError: a value is not possible.
    """
    numbers = _numbers(added, where, "[mass in kg, place in m] or with the inertia in kg m^2", 3)
    mass, place, inertia = (*numbers, 0.0)[:3]
    std = (STANDARD_RELATIVE_STD * mass, STANDARD_PLACE_STD) if std is None else std
    mass_std, place_std = _numbers(std, where_std, "[of the mass in kg, of the place in m]")
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


def _numbers(given: Any, where: str, expected: str, most: int = 2) -> list[float]:
    if not isinstance(given, Sequence) or isinstance(given, str | bytes) or not 2 <= len(given) <= most:
        raise OptionError(f"{where} is {quoted(given)}; expected {expected}")
    return [number(x, where, 0.0, limit) for x, limit in zip(given, (_HEAVIEST, _FARTHEST, _HEAVIEST), strict=False)]
