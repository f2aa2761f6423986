# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known about the physical parameters before any trial: nominal values, ranges, and what was measured."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import OptionError
from cdp_ident.model.acting import outer_rod_length
from cdp_ident.model.parameters import CONSTANTS, LARGEST, NOMINAL, PARAMETERS, SYMBOLS, inertia_about_cart
from cdp_ident.user_input import refuse_unknown

_RANGE_IN_DEVIATIONS = 4.0
"""A search range, from lower to upper limit, is taken for so many standard deviations of the nominal value."""
_GUESSED_SCALE = np.log(3.0)
"""Standard deviation of the logarithm of one factor on all masses of which nothing but the paper's rig is known."""
FARTHEST = 20.0
"""No value, and no error of a weight, is further from what was known before than so many of its standard deviations;
this is also the standard deviation of a logarithm of which nothing is known."""
KNOWN_RELATIVE_STD = 0.01
"""Relative standard deviation of a known value for which none is given."""


@dataclass(frozen=True)
class Prior:
    """The rig's constants, the nominal values and ranges, and measured values; by symbol, in SI units.

    Raises:
        OptionError: a symbol is unknown, or a value is not possible.
    """

    nominal: Mapping[str, float] = field(default_factory=dict)
    """Estimates; those of the paper's rig (Table 2) where missing. L and g are among them. One that is just the paper's
    says nothing of how heavy another rig is."""
    lower: Mapping[str, float] = field(default_factory=dict)
    """Lower limits of the search; the paper's factors on the nominal values where missing."""
    upper: Mapping[str, float] = field(default_factory=dict)
    """Upper limits."""
    known: Mapping[str, float] = field(default_factory=dict)
    """What was weighed or measured; it takes the place of the nominal value."""
    known_std: Mapping[str, float] = field(default_factory=dict)
    """Standard deviations of the known values; 1 % where missing."""

    def __post_init__(self) -> None:
        for name in ("nominal", "lower", "upper", "known", "known_std"):
            values = getattr(self, name)
            refuse_unknown(values, NOMINAL if name == "nominal" else SYMBOLS, f"parameter in {name}")
            for symbol, value in values.items():
                lowest_allowed = symbol in ("m0", "c1", "c2") or name == "lower"
                if not 0 <= value <= LARGEST or (value == 0 and not lowest_allowed):
                    called = f"{name}.{symbol}" if symbol in SYMBOLS else symbol
                    raise OptionError(f"{called} is {value}; it must be a positive number, at most {LARGEST:g}")
        for of in CONSTANTS:
            least, most = of.nominal * of.lower_factor, of.nominal * of.upper_factor
            if not least <= self.constant(of.symbol) <= most:
                given = f"{of.symbol} is {self.constant(of.symbol):g} {of.unit}"
                raise OptionError(f"{given}; expected {least:.3g} to {most:.3g} {of.unit}: in another unit?")
        if unmatched := sorted(set(self.known_std) - set(self.known)):
            raise OptionError(f"known_std.{unmatched[0]} is given, but known.{unmatched[0]} is not: give both")
        for symbol, low, high in zip(SYMBOLS, self.box[0], self.box[1], strict=True):
            if low > high:
                raise OptionError(f"lower.{symbol} is {low:g}, above upper.{symbol}, {high:g}: exchange them")

    def constant(self, symbol: str) -> float:
        """Return L [m] or g [m/s^2]."""
        return float(self.nominal.get(symbol, NOMINAL[symbol]))

    @property
    def length(self) -> float:
        """L [m]."""
        return self.constant(CONSTANTS[0].symbol)

    @property
    def gravity(self) -> float:
        """Acceleration of gravity g [m/s^2]."""
        return self.constant(CONSTANTS[1].symbol)

    @property
    def centre(self) -> Array:
        """(9,) best values before any trial: the known ones, else the nominal ones."""
        return np.array([self.known.get(symbol, self.nominal.get(symbol, NOMINAL[symbol])) for symbol in SYMBOLS])

    @property
    def box(self) -> tuple[Array, Array]:
        """Lower and upper limits (9,) of the search, Eq. (9)."""
        centre = self.centre
        factors = np.array([(parameter.lower_factor, parameter.upper_factor) for parameter in PARAMETERS]).T
        lower = [self.lower.get(s, low) for s, low in zip(SYMBOLS, centre * factors[0], strict=True)]
        upper = [self.upper.get(s, high) for s, high in zip(SYMBOLS, centre * factors[1], strict=True)]
        return np.array(lower), np.array(upper)

    @property
    def is_known(self) -> Mask:
        """(9,) whether a value was measured."""
        return np.array([symbol in self.known for symbol in SYMBOLS])

    @property
    def relative_std(self) -> Array:
        """(9,) standard deviations of the logarithms of `centre`: how far the value may well be off."""
        deviations = []
        for symbol, parameter, value in zip(SYMBOLS, PARAMETERS, self.centre, strict=True):
            if symbol in self.known:
                deviations.append(self.known_std.get(symbol, KNOWN_RELATIVE_STD * value) / value if value else 0.0)
            else:
                deviations.append(np.log(parameter.upper_factor / parameter.lower_factor) / _RANGE_IN_DEVIATIONS)
        return np.maximum(np.array(deviations), 1e-6)

    @property
    def covariance(self) -> Array:
        """(9, 9) covariance of the logarithms of `centre`.

        Masses, inertias and frictions that are only the paper's may all be off by one factor besides.
        """
        scaled = [
            p.symbol not in ("l1", "l2", *self.known) and value == p.nominal
            for p, value in zip(PARAMETERS, self.centre, strict=True)
        ]
        return np.diag(self.relative_std**2) + _GUESSED_SCALE**2 * np.outer(scaled, scaled)


@dataclass(frozen=True)
class Mechanism:
    """What the model must know of the rig beforehand, because no zero-input trial shows it."""

    length: float
    """L [m], or the value to begin with where it is free."""
    gravity: float
    """g [m/s^2], or the value to begin with where it is free."""
    outer_length: float
    """Length of the outer rod [m]."""
    inertia: float
    """A22 [kg m^2], or the value to begin with where it is free."""

    @classmethod
    def of(cls, prior: Prior) -> "Mechanism":
        """Take it from what is known before any trial."""
        l2 = float(prior.centre[SYMBOLS.index("l2")])
        inertia = float(inertia_about_cart(prior.centre, prior.length))
        return cls(prior.length, prior.gravity, outer_rod_length(prior.length, l2), inertia)
