"""The fitted model made anew of the values by which `fitted.yaml` and the node `identify` describe it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.errors import OptionError
from cdp_ident.fit.motion_model import ActiveEffect, Mechanism, MotionModel
from cdp_ident.model.effects.constants import outer_rod_length
from cdp_ident.model.effects.naming import effect_of
from cdp_ident.model.parameters import GROUPS, NOMINAL, SYMBOLS, groups_of, inertia_about_cart, physical_coefficients
from cdp_ident.user_input import number, refuse_unknown

Array = npt.NDArray[np.float64]

GROUP_PREFIX, EFFECT_PREFIX = "groups.", "effects."
OUTER_ROD_LENGTH = "outer_rod_length"
"""Name of the length that the air drag of the outer rod is taken to act along [m]."""
TRIAL = "trial"
"""Last part of the name that says in which trial an effect happened once."""
ABOUT_THE_FIT = ("std.", "determined.")
"""What `fitted.yaml` says of the values beside them begins so."""

_GROUP_NAMES = tuple(f"{GROUP_PREFIX}{group.symbol}" for group in GROUPS)
_NAMES = (*NOMINAL, *_GROUP_NAMES, OUTER_ROD_LENGTH)
_ELSEWHERE = -1
"""Number of every trial in which no effect happens that happens once."""


@dataclass(frozen=True)
class FittedModel:
    """A model and its values: what an identification ended with."""

    physical: Mapping[str, float]
    """The physical parameters by symbol, L and g among them, in SI units."""
    motion: MotionModel
    """The model with its effects."""
    values: Array
    """(unknowns,) values of its unknowns, torques over A22."""
    trials: tuple[str, ...] = ()
    """Names of the trials in which an effect happens once; `ActiveEffect.trial` is the place here."""

    @property
    def coefficients(self) -> Array:
        """The coefficients (7,) of the equations of motion."""
        return self.motion.coefficients(self.values)

    def trial(self, name: str | None = None) -> int:
        """Return the number by which the model knows the trial of this name; without one, any other trial's."""
        return self.trials.index(name) if name in self.trials else _ELSEWHERE


def describes_model(name: str) -> bool:
    """Return whether a parameter of this name is one that `fitted_model` makes the model of."""
    return name in _NAMES or name.startswith(EFFECT_PREFIX)


def read_fitted_model(path: Path, node: str) -> FittedModel:
    """Read the model of a `fitted.yaml`, from the section for `node` or for every node.

    Raises:
        OptionError: the file cannot be read, or does not describe a model.
    """
    return fitted_model(read_parameter_file(path, node), str(path))


def fitted_model(given: Mapping[str, Any], where: str) -> FittedModel:
    """Make the model that parameters describe.

    They are named as `report.fitted.fitted_parameters` does: the physical parameters; the groups, which are those of
    the physical parameters where they are not given; effects in SI units. Standard deviations and what was determined
    are passed over.

    Args:
        given: values by name.
        where: what the values stand in, for messages.

    Raises:
        OptionError: a name is unknown (the nearest known one is told), or a value is missing or not possible.
    """
    refuse_unknown(
        (n for n in given if not describes_model(n) and not n.startswith(ABOUT_THE_FIT)), _NAMES, f"name in {where}"
    )
    if missing := [symbol for symbol in NOMINAL if symbol not in given]:
        raise OptionError(f"{where} lacks {', '.join(missing)}; all of {', '.join(NOMINAL)} are needed")
    physical = {symbol: number(given[symbol], f"{where}: {symbol}", 0.0) for symbol in NOMINAL}
    groups = _groups(given, physical, where)
    inertia = float(inertia_about_cart(np.array([physical[symbol] for symbol in SYMBOLS]), physical["L"]))
    if inertia <= 0.0:
        raise OptionError(f"{where}: the inertia about the cart's joint is 0; a mass must be above 0")
    length = outer_rod_length(physical["L"], physical["l2"])
    length = number(given.get(OUTER_ROD_LENGTH, length), f"{where}: {OUTER_ROD_LENGTH}", 1e-6)
    motion, values = MotionModel(Mechanism(physical["L"], physical["g"], length)), groups
    trials: list[str] = []
    for name, joint, parameters in _effects(given, where):
        trial = parameters.pop(TRIAL, None)
        effect, own = effect_of(name, joint, parameters, inertia, where)
        if effect.at_an_instant and not (isinstance(trial, str) and trial):
            raise OptionError(
                f"{where}: {name}: {joint}: {TRIAL}, the name of the trial that it happened in, is missing"
            )
        if effect.at_an_instant and trial not in trials:
            trials.append(trial)
        active = ActiveEffect(effect, trials.index(trial) if effect.at_an_instant else None)
        fitted = [value for p, value in zip(effect.parameters, own, strict=True) if not p.fixed]
        motion, values = motion.with_effect(active), np.concatenate([values, fitted])
    return FittedModel(physical, motion, values, tuple(trials))


def _groups(given: Mapping[str, Any], physical: Mapping[str, float], where: str) -> Array:
    there = [name for name in _GROUP_NAMES if name in given]
    if not there:
        try:
            physical_coefficients(physical)
        except OptionError as error:
            raise OptionError(f"{where}: {error}") from error
        return groups_of(np.array([physical[symbol] for symbol in SYMBOLS]), physical["L"])
    if missing := [name for name in _GROUP_NAMES if name not in given]:
        raise OptionError(f"{where} lacks {', '.join(missing)}; give all groups, or none")
    groups = np.array([number(given[name], f"{where}: {name}", 0.0) for name in _GROUP_NAMES])
    if groups[1] <= groups[0] ** 2 or physical["L"] == 0.0:
        raise OptionError(
            f"{where}: these groups describe no mechanism: A33/A22 must exceed the square of A23/A22, and L be "
            f"positive; they are {groups[1]:g} and {groups[0]:g}, and L is {physical['L']:g} m"
        )
    return groups


def _effects(given: Mapping[str, Any], where: str) -> Iterable[tuple[str, str, dict[str, Any]]]:
    """Yield name, joint and parameters of each effect, in the order given.

    Of an effect that a joint has more than once, the later ones have a number after the joint.
    """
    found: dict[tuple[str, ...], dict[str, Any]] = {}
    for name, value in given.items():
        if name.startswith(EFFECT_PREFIX):
            *place, parameter = name.removeprefix(EFFECT_PREFIX).split(".")
            if len(place) not in (2, 3) or (len(place) == 3 and not place[2].isdecimal()):
                raise OptionError(
                    f"{where}: {name} is no parameter of an effect: expected effects.<name>.<joint>.<parameter>"
                )
            found.setdefault(tuple(place), {})[parameter] = value
    for (name, joint, *_), parameters in found.items():
        yield name, joint, parameters
