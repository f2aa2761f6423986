# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""All settings of an identification by their keys: from names and values to the options of the library, and back.

The defaults, and most descriptions, are those of the dataclasses that the values end up in.
"""

import math
import re
from array import array
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from cdp_ident.configuration.described import Described, described_fields
from cdp_ident.configuration.fitted_model import is_shown
from cdp_ident.errors import OptionError
from cdp_ident.fit.objective import SHORT_IGA
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.model.parameters import CONSTANTS, NOMINAL, PARAMETERS, SYMBOLS
from cdp_ident.model.weights import ADDED, ADDED_STD, DESCRIPTIONS, NOTHING, RODS, Rod, Weight, settings_of, weights_of
from cdp_ident.outside_text import shown
from cdp_ident.search.options import METHODS
from cdp_ident.trial.options import TrialOptions
from cdp_ident.user_input import quoted, refuse_unknown

Scalar = bool | int | float | str

WEIGHTS = "trials."
"""What the names of weights on the rods in a trial begin with; the name of its bag follows."""
_OF_WEIGHT = re.compile(rf"{re.escape(WEIGHTS)}(.+)\.(({ADDED}|{ADDED}_std)\.({'|'.join(RODS)}))")
_METHOD = Described(
    "method",
    "",
    "the paper's search in full, by name; empty: the improved one, cut short, as the fit takes over from it",
    choices=("", *METHODS),
)
_BELIEVED: dict[type, tuple[float, float]] = {int: (1, 2**63 - 1), float: (1e-12, 1e12)}
"""Smallest and largest number that somebody may mean, beside 0 and infinity."""
_PRIOR = {
    "nominal": "estimate: {0.description}",
    "lower": "lower limit of the search for {0.symbol}; {0.lower_factor:g} times its nominal value if not given",
    "upper": "upper limit of the search for {0.symbol}; {0.upper_factor:g} times its nominal value if not given",
    "known": "weighed or measured, takes the nominal value's place: {0.description}",
    "known_std": "standard deviation of known.{0.symbol}; 1 % of it if not given",
}
"""What `Prior` has of each parameter, and what is said of it."""


def _physical() -> Iterator[Described]:
    for constant in CONSTANTS:
        yield Described(constant.symbol, constant.nominal, constant.description, constant.unit, 0.0)
    for group, text in _PRIOR.items():
        for parameter in PARAMETERS:
            factors = {"nominal": 1.0, "lower": parameter.lower_factor, "upper": parameter.upper_factor}
            default = parameter.nominal * factors[group] if group in factors else None
            yield Described(f"{group}.{parameter.symbol}", default, text.format(parameter), parameter.unit, 0.0)


def _of_options(options: Any, prefix: str) -> Iterator[Described]:
    return (key for key in described_fields(options, prefix) if isinstance(key.value, Scalar))


KEYS = {
    key.name: key
    for key in (
        *_physical(),
        _METHOD,
        *_of_options(IdentifyOptions(), ""),
        *_of_options(TrialOptions(), "trial."),
        *_of_options(SHORT_IGA, "search."),  # without any told, what they are depends on the method
    )
}
"""Every key by its name."""


def is_key(name: str) -> bool:
    """Return whether a name is one of `KEYS`, or that of a weight."""
    return name in KEYS or weight_name(name) is not None


def weight_name(name: str) -> tuple[str, str] | None:
    """Return bag and `added.<rod>` or `added_std.<rod>` of the name of a weight; None of another name."""
    found = _OF_WEIGHT.fullmatch(name)
    return (found[1], found[2]) if found else None


def description_of(name: str) -> Described:
    """Return the key of a name; of a weight, whose value is a list of numbers, what each of them is."""
    if (found := _OF_WEIGHT.fullmatch(name)) is None:
        return KEYS[name]
    return Described(name, None, f"{found[1]}: {DESCRIPTIONS[found[3]].format(rod=found[4])}")


@dataclass(frozen=True)
class Settings:
    """All settings of an identification except its bags."""

    identify: IdentifyOptions = field(default_factory=IdentifyOptions)
    trial: TrialOptions = field(default_factory=TrialOptions)
    weights: Mapping[str, Mapping[Rod, Weight | None]] = field(default_factory=dict)
    """Weights on the rods by bag and rod, None where there is none; they win over what the bag says."""

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> "Settings":
        """Make settings of values by name (see `KEYS`); what is not given has its default.

        Raises:
            OptionError: a name is unknown (the message gives the nearest known one), or a value is of the wrong type or
                not possible.
        """
        weights = _weights(given)
        given = {name: value for name, value in given.items() if weight_name(name) is None}
        for name in given:
            if name.startswith(WEIGHTS):
                raise OptionError(
                    f"unknown key of identify: {quoted(name)}; expected {WEIGHTS}<bag>.{ADDED}.<rod> or "
                    f"{WEIGHTS}<bag>.{ADDED_STD}.<rod>, rods being {' and '.join(RODS)}"
                )
        refuse_unknown(given, KEYS, "key of identify")
        values: dict[str, Any] = {name: _checked(KEYS[name], value) for name, value in given.items()}
        prior = {group: _below(f"{group}.", values) for group in _PRIOR}
        prior["nominal"] |= {
            constant.symbol: values[constant.symbol] for constant in CONSTANTS if constant.symbol in values
        }
        top: dict[str, Any] = {
            name: value for name, value in values.items() if name in IdentifyOptions.__dataclass_fields__
        }
        top["method"] = top.get("method") or None
        if top.get("seed", 0) < 0:
            raise OptionError(f"seed is {top['seed']}; it must be 0 or more")
        options = IdentifyOptions(prior=Prior(**prior), **top)
        if search := _below("search.", values):
            options = replace(options, genetic=replace(options.search, **search))
        try:
            return cls(options, TrialOptions(**_below("trial.", values)), weights)
        except OptionError as error:
            raise OptionError(f"trial.{error}") from error

    def values(self) -> dict[str, Scalar | list[float]]:
        """Return every value in effect, by name: what these settings can be made of again."""
        options, prior = self.identify, self.identify.prior
        values: dict[str, Scalar | list[float]] = {
            constant.symbol: prior.constant(constant.symbol) for constant in CONSTANTS
        }
        values |= {f"nominal.{symbol}": prior.nominal.get(symbol, NOMINAL[symbol]) for symbol in SYMBOLS}
        for limit, limits in zip(("lower", "upper"), prior.box, strict=True):
            values |= {f"{limit}.{symbol}": float(value) for symbol, value in zip(SYMBOLS, limits, strict=True)}
        for group in ("known", "known_std"):
            values |= {f"{group}.{symbol}": float(value) for symbol, value in getattr(prior, group).items()}
        values["method"] = options.method or ""
        for prefix, source in (("", options), ("trial.", self.trial), ("search.", options.search)):
            of_source = {f"{prefix}{name}": value for name, value in vars(source).items()}
            values |= {name: value for name, value in of_source.items() if name in KEYS and name not in values}
        for bag, weights in self.weights.items():
            for rod, weight in weights.items():
                given = settings_of([weight]) if weight else {f"{ADDED}.{rod}": list(NOTHING)}
                values |= {f"{WEIGHTS}{bag}.{name}": value for name, value in given.items()}
        return values


def is_result(name: str) -> bool:
    """Return whether a parameter of this name is one that `identify` shows with its result, and no setting of it."""
    return is_shown(name) and not is_key(name)


def without_results(given: Mapping[str, Any]) -> tuple[dict[str, Any], str]:
    """Return the settings among what is given, and a line about results that are passed over; empty for none.

    `ros2 param dump` writes what `identify` found beside its settings: given back, it is no setting.
    """
    results = [name for name in given if is_result(name)]
    named = f"{', '.join(map(shown, results[:3]))}{' …' if len(results) > 3 else ''}"
    line = f"{named}: results of an earlier identification, passed over (estimates are nominal.m1 and so on)"
    return {name: value for name, value in given.items() if not is_result(name)}, line if results else ""


def given_for(given: Mapping[str, Any], bags: Collection[str]) -> dict[str, Any]:
    """Return of what is given for many bags what concerns some, by their names: weights of others are left out."""
    return {name: value for name, value in given.items() if not (of := weight_name(name)) or of[0] in bags}


def _weights(given: Mapping[str, Any]) -> dict[str, dict[Rod, Weight | None]]:
    by_bag: dict[str, dict[str, Any]] = {}
    for name, value in given.items():
        if place := weight_name(name):
            by_bag.setdefault(place[0], {})[place[1]] = list(value) if isinstance(value, array) else value
    return {bag: weights_of(of_bag, f"{WEIGHTS}{shown(bag)}") for bag, of_bag in by_bag.items()}


def _below(prefix: str, values: Mapping[str, Any]) -> dict[str, Any]:
    return {name.removeprefix(prefix): value for name, value in values.items() if name.startswith(prefix)}


def _checked(key: Described, value: Any) -> Scalar:
    """Return a value as the key's type.

    A whole number may stand for a real one; ROS takes `1e-3` for a number, YAML for a string.
    """
    kind = float if key.value is None else type(key.value)
    checked: Scalar | None = None
    if kind is float and not isinstance(value, bool):
        try:
            checked = float(value) + 0.0  # -0.0 is 0.0
        except (TypeError, ValueError, OverflowError):
            checked = None
    elif type(value) is kind:
        checked = value
    if checked is None or (isinstance(checked, float) and math.isnan(checked)):
        kinds = {float: "a number", int: "a whole number", bool: "true or false", str: "text"}
        raise OptionError(f"{key.name} is {quoted(value)}: expected {kinds[kind]} ({key.description})")
    if kind in _BELIEVED and isinstance(checked, int | float) and checked and abs(checked) != math.inf:
        smallest, largest = _BELIEVED[kind]
        if not smallest <= abs(checked) <= largest:
            raise OptionError(f"{key.name} is {quoted(value)}: such a number is not believed")
    if key.choices and checked not in key.choices:
        raise OptionError(f"{key.name} is {quoted(value)}: expected one of {', '.join(map(repr, key.choices))}")
    return checked
