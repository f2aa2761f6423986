# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fitted model by named values, as `fitted.yaml` and the node `identify` have it: written from a report, read back.

The physical parameters, the base parameters (`groups.<symbol>`) and the effects (`effects.<name>.<joint>.<parameter>`),
with `std.<name>` and `determined.<name>` beside them.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.configuration.described import Described
from cdp_ident.configuration.parameter_file import parameter_file, read_parameter_file
from cdp_ident.errors import OptionError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism
from cdp_ident.model.acting import outer_rod_length
from cdp_ident.model.effects import own
from cdp_ident.model.effects.catalogue import COEFFICIENTS, VARIANT, effect_of
from cdp_ident.model.parameters import (
    CONSTANTS,
    GROUPS,
    INERTIA,
    LARGEST,
    NOMINAL,
    PARAMETERS,
    SYMBOLS,
    groups_of,
    inertia_about_cart,
    physical_coefficients,
)
from cdp_ident.outside_text import shown
from cdp_ident.user_input import number, refuse_unknown

GROUP_PREFIX, EFFECT_PREFIX = "groups.", "effects."
OUTER_ROD_LENGTH = "outer_rod_length"
"""Name of the length that the air drag of the outer rod is taken to act along [m]."""
TRIAL = "trial"
"""Last part of the name that says in which trial an effect happened once."""
ABOUT_THE_FIT = ("std.", "determined.")
"""What `fitted.yaml` says of the values beside them begins so."""

OF_MECHANISM: dict[str, tuple[str, str]] = {
    **{parameter.symbol: (parameter.description, parameter.unit) for parameter in (*PARAMETERS, *CONSTANTS, INERTIA)},
    **{f"{GROUP_PREFIX}{group.symbol}": (group.formula, group.unit) for group in GROUPS},
    OUTER_ROD_LENGTH: ("what the outer rod's length is taken to be, for air drag along it", "m"),
    own.OWN_EFFECTS: ("definitions of the user's own effects", ""),
}
"""Description and unit of each parameter of a model but those of its effects."""
_GROUP_NAMES = tuple(f"{GROUP_PREFIX}{group.symbol}" for group in GROUPS)
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

    def dry_friction(self, joint: str) -> float:
        """Return the torque of dry friction in a joint, as simulators take it: the same at all speeds [N m]."""
        known = zip(self.motion.names, self.values.tolist(), strict=True)
        torques = [value for name, value in known if name.endswith(f"friction.{joint}.torque")]
        return sum(torques) * self.motion.mechanism.inertia

    def with_motors(self) -> "FittedModel":
        """Return it with motors in the joints, whose torques act as they are recorded."""
        motion = replace(self.motion, motors=True)
        more = np.zeros(len(motion.of_motors))
        return replace(self, motion=motion, values=np.insert(self.values, motion.places_of_motors.start, more))

    def trial(self, name: str | None = None) -> int:
        """Return the number by which the model knows the trial of this name; without one, any other trial's."""
        return self.trials.index(name) if name in self.trials else _ELSEWHERE


def describes_model(name: str) -> bool:
    """Return whether a parameter of this name is one that `fitted_model` makes the model of."""
    return name in OF_MECHANISM or name.startswith(EFFECT_PREFIX)


def is_shown(name: str) -> bool:
    """Return whether `fitted_parameters` has a parameter of this name, or one may be given in its place."""
    return describes_model(name) or name.startswith(ABOUT_THE_FIT)


def follows_from_physical_values(name: str) -> bool:
    """Return whether a parameter of this name is another one for other physical values."""
    return name == INERTIA.symbol or name.startswith(GROUP_PREFIX)


def fitted_parameters(report: Mapping[str, Any]) -> Iterator[Described]:
    """Yield the parameters of the model that a report ends with: first their values.

    Then `std.<name>`, infinite where the trials do not show the parameter at all, and `determined.<name>`: whether
    trials and measured values determine it; at last the effects, `effects.<name>.<joint>.<parameter>`. Of an effect
    that a joint has more than once (impulses), the later ones have a number after the joint:
    `effects.impulse.inner.2.…`.
    """
    fit = report["after"]
    quantities = {
        **fit["physical"],
        **{f"{GROUP_PREFIX}{symbol}": quantity for symbol, quantity in fit["groups"].items()},
    }
    for name, quantity in quantities.items():
        yield Described(name, quantity["value"], f"fitted: {OF_MECHANISM[name][0]}", quantity["unit"], 0.0)
    for name, quantity in quantities.items():
        yield Described(f"std.{name}", quantity["std"], f"standard deviation of {name}", quantity["unit"])
    for name, quantity in quantities.items():
        yield Described(f"determined.{name}", quantity["determined"], f"whether the trials determine {name}")
    text = "taken to be: length of the outer rod, for air drag along it"
    yield Described(OUTER_ROD_LENGTH, fit["outer_rod_length_m"], text, "m", 0.0)
    if report["own_effects"]:
        yield Described(own.OWN_EFFECTS, own.as_text(report["own_effects"]), OF_MECHANISM[own.OWN_EFFECTS][0])
    seen: Counter[str] = Counter()
    for effect in report["effects"]:
        prefix = f"{EFFECT_PREFIX}{effect['name']}.{effect['joint']}"
        seen[prefix] += 1
        yield from _effect_parameters(effect, prefix if seen[prefix] == 1 else f"{prefix}.{seen[prefix]}")


def _effect_parameters(effect: Mapping[str, Any], prefix: str) -> Iterator[Described]:
    for name in (VARIANT, TRIAL):
        if effect[name]:
            yield Described(f"{prefix}.{name}", effect[name], f"{name} of {effect['description']}")
    description = f"{effect['description']}: {effect['formula']}"
    if curve := effect["curve"]:
        name = f"{prefix}.{COEFFICIENTS}"
        yield Described(name, curve["coefficients"], description, "N m")
        yield Described(f"std.{name}", curve["coefficients_std"], "their standard deviations", "N m")
        return
    for name, quantity in effect["parameters"].items():
        yield Described(f"{prefix}.{name}", quantity["value"], description, quantity["unit"])
    for name, quantity in effect["parameters"].items():
        description = f"standard deviation of {prefix}.{name}"
        yield Described(f"std.{prefix}.{name}", quantity["std"], description, quantity["unit"])


def fitted_yaml(report: Mapping[str, Any]) -> str:
    """Return the text of `fitted.yaml`."""
    values = {parameter.name: parameter.value for parameter in fitted_parameters(report)}
    bags = ", ".join(trial["name"] for trial in report["trials"] if trial["role"] == "fit")
    comments = [f"Fitted by cdp_ident identify from {shown(bags)}; report.json tells how. SI units, radians."]
    return parameter_file(values, comments)


def read_fitted_model(path: Path, node: str) -> FittedModel:
    """Read the model of a file such as `fitted.yaml` that is meant for a node; raises as `fitted_model` does."""
    return fitted_model(read_parameter_file(path, node).taken(), str(path))


@np.errstate(all="ignore")
def fitted_model(given: Mapping[str, Any], where: str) -> FittedModel:
    """Make the model that parameters describe.

    They are named as `fitted_parameters` does: the physical parameters; the base parameters and A22, which are those of
    the physical parameters where they are not given; effects in SI units. Standard deviations and what was determined
    are passed over. `where` says what the values stand in, for messages.

    Raises:
        OptionError: a name is unknown (the message gives the nearest known one), or a value is missing or not possible.
    """
    refuse_unknown((name for name in given if not is_shown(name)), OF_MECHANISM, f"name in {where}")
    if missing := [symbol for symbol in NOMINAL if symbol not in given]:
        raise OptionError(f"{where} lacks {', '.join(missing)}; all of {', '.join(NOMINAL)} are needed")
    physical = {symbol: number(given[symbol], f"{where}: {symbol}", 0.0, LARGEST) for symbol in NOMINAL}
    groups = _groups(given, physical, where)
    inertia = float(inertia_about_cart(np.array([physical[symbol] for symbol in SYMBOLS]), physical["L"]))
    inertia = number(given.get(INERTIA.symbol, inertia), f"{where}: {INERTIA.symbol}", 0.0)
    if inertia <= 0.0:
        raise OptionError(f"{where}: the inertia about the cart's joint is 0; a mass must be above 0")
    length = outer_rod_length(physical["L"], physical["l2"])
    length = number(given.get(OUTER_ROD_LENGTH, length), f"{where}: {OUTER_ROD_LENGTH}", 1e-6)
    if text := given.get(own.OWN_EFFECTS):
        own.use(own.of_text(text, where), inertia, where)
    motion, values = MotionModel(Mechanism(physical["L"], physical["g"], length, inertia)), groups
    trials: list[str] = []
    for name, joint, parameters in _effects(given, where):
        trial = parameters.pop(TRIAL, None)
        effect, of_effect = effect_of(name, joint, parameters, inertia, where)
        once = effect.at_an_instant or (trial is not None and not effect.states)
        if once and not (isinstance(trial, str) and trial):
            raise OptionError(f"{where}: {name}: {joint}: {TRIAL}, the name of the trial that it acts in, is missing")
        if once and trial not in trials:
            trials.append(trial)
        active = ActiveEffect(effect, trials.index(trial) if once else None)
        fitted = [value for p, value in zip(effect.parameters, of_effect, strict=True) if not p.fixed]
        motion, values = motion.with_effect(active), np.concatenate([values, fitted])
    model = FittedModel(physical, motion, values, tuple(trials))
    if not np.all(np.abs(model.coefficients) <= LARGEST):
        raise OptionError(f"{where}: these values describe no pendulum: one is far too small against another")
    return model


def _groups(given: Mapping[str, Any], physical: Mapping[str, float], where: str) -> Array:
    there = [name for name in _GROUP_NAMES if name in given]
    if not there:
        try:
            physical_coefficients(physical)
        except OptionError as error:
            raise OptionError(f"{where}: {error}") from error
        return groups_of(np.array([physical[symbol] for symbol in SYMBOLS]), physical["L"])
    if missing := [name for name in _GROUP_NAMES if name not in given]:
        raise OptionError(f"{where} lacks {', '.join(missing)}; give all base parameters (groups.*), or none")
    groups = np.array([number(given[name], f"{where}: {name}", 0.0, LARGEST) for name in _GROUP_NAMES])
    if groups[1] <= groups[0] ** 2 or physical["L"] == 0.0:
        raise OptionError(
            f"{where}: these base parameters describe no mechanism: A33/A22 must exceed the square of A23/A22, and L "
            f"be positive; they are {groups[1]:g} and {groups[0]:g}, and L is {physical['L']:g} m"
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
