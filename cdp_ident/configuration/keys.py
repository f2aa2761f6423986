# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The table of all configuration keys of an identification.

The defaults, and most descriptions, are those of the dataclasses that the values end up in.
"""

import dataclasses
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin, get_type_hints

from cdp_ident.configuration.field_documentation import field_documentation, without_unit
from cdp_ident.fit.objective import SHORT_IGA
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.parameters import CONSTANTS, PARAMETERS
from cdp_ident.model.weights import ADDED, DESCRIPTIONS, RODS
from cdp_ident.search.options import METHODS, GeneticOptions
from cdp_ident.trial.options import TrialOptions

Scalar = bool | int | float | str

WEIGHTS = "trials."
"""What the names of weights on the rods in a trial begin with; the name of its bag follows."""
_OF_WEIGHT = re.compile(rf"{re.escape(WEIGHTS)}(.+)\.(({ADDED}|{ADDED}_std)\.({'|'.join(RODS)}))")


@dataclass(frozen=True)
class Key:
    """One configuration key."""

    name: str
    kind: type[Scalar]
    """bool, int, float or str."""
    default: Scalar | None
    """None: it is not set, or it follows from other keys, as the description says."""
    description: str
    unit: str = ""
    minimum: float | None = None
    choices: tuple[str, ...] = ()
    fixed_default: bool = True
    """Whether the default depends on nothing else."""


def _constants() -> Iterator[Key]:
    for constant in CONSTANTS:
        yield Key(constant.symbol, float, constant.nominal, constant.description, constant.unit, 0.0)


def _physical() -> Iterator[Key]:
    for parameter in PARAMETERS:
        symbol, unit = parameter.symbol, parameter.unit
        yield Key(f"nominal.{symbol}", float, parameter.nominal, f"estimate: {parameter.description}", unit, 0.0)
    for limit in ("lower", "upper"):
        for parameter in PARAMETERS:
            factor = getattr(parameter, f"{limit}_factor")
            text = (
                f"{limit} limit of the search for {parameter.symbol}; {factor:g} times its nominal value if not given"
            )
            default = parameter.nominal * factor
            yield Key(f"{limit}.{parameter.symbol}", float, default, text, parameter.unit, 0.0, fixed_default=False)
    for parameter in PARAMETERS:
        text = f"weighed or measured, takes the nominal value's place: {parameter.description}"
        yield Key(f"known.{parameter.symbol}", float, None, text, parameter.unit, 0.0, fixed_default=False)
    for parameter in PARAMETERS:
        text = f"standard deviation of known.{parameter.symbol}; 1 % of it if not given"
        yield Key(f"known_std.{parameter.symbol}", float, None, text, parameter.unit, 0.0, fixed_default=False)


def _of_dataclass(of: type[Any], defaults: Any, prefix: str, fixed_defaults: bool = True) -> Iterator[Key]:
    kinds, documentation = get_type_hints(of), field_documentation(of)
    for field in dataclasses.fields(of):
        kind = kinds[field.name]
        choices = get_args(kind) if get_origin(kind) is Literal else ()
        if choices:
            kind = str
        if kind in (bool, int, float, str):
            description, unit = without_unit(documentation[field.name])
            default = getattr(defaults, field.name)
            yield Key(prefix + field.name, kind, default, description, unit, None, choices, fixed_defaults)


def _method() -> Key:
    text = "the paper's search in full, by name; empty: the improved one, cut short, as the fit takes over from it"
    return Key("method", str, "", text, choices=("", *METHODS))


KEYS = {
    key.name: key
    for key in (
        *_constants(),
        *_physical(),
        _method(),
        *_of_dataclass(IdentifyOptions, IdentifyOptions(), ""),
        *_of_dataclass(TrialOptions, TrialOptions(), "trial."),
        # What the search's settings are if not given, depends on the method.
        *_of_dataclass(GeneticOptions, SHORT_IGA, "search.", fixed_defaults=False),
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


def description_of(name: str) -> Key:
    """Return the key of a name; of a weight, whose value is a list of numbers, what each of them is."""
    if (found := _OF_WEIGHT.fullmatch(name)) is None:
        return KEYS[name]
    return Key(name, float, None, f"{found[1]}: {DESCRIPTIONS[found[3]].format(rod=found[4])}", fixed_default=False)
