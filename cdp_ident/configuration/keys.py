# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The table of all configuration keys of an identification.

The defaults, and most descriptions, are those of the dataclasses that the values end up in.
"""

import re
from collections.abc import Iterator
from typing import Any

from cdp_ident.configuration.described import Described, described_fields
from cdp_ident.fit.objective import SHORT_IGA
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.parameters import CONSTANTS, PARAMETERS
from cdp_ident.model.weight_settings import ADDED, DESCRIPTIONS
from cdp_ident.model.weights import RODS
from cdp_ident.search.options import METHODS
from cdp_ident.trial.options import TrialOptions

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


def _physical() -> Iterator[Described]:
    for constant in CONSTANTS:
        yield Described(constant.symbol, constant.nominal, constant.description, constant.unit, 0.0)
    for parameter in PARAMETERS:
        text = f"estimate: {parameter.description}"
        yield Described(f"nominal.{parameter.symbol}", parameter.nominal, text, parameter.unit, 0.0)
    for limit in ("lower", "upper"):
        for parameter in PARAMETERS:
            factor = getattr(parameter, f"{limit}_factor")
            text = (
                f"{limit} limit of the search for {parameter.symbol}; {factor:g} times its nominal value if not given"
            )
            yield Described(f"{limit}.{parameter.symbol}", parameter.nominal * factor, text, parameter.unit, 0.0)
    for parameter in PARAMETERS:
        text = f"weighed or measured, takes the nominal value's place: {parameter.description}"
        yield Described(f"known.{parameter.symbol}", None, text, parameter.unit, 0.0)
    for parameter in PARAMETERS:
        text = f"standard deviation of known.{parameter.symbol}; 1 % of it if not given"
        yield Described(f"known_std.{parameter.symbol}", None, text, parameter.unit, 0.0)


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
