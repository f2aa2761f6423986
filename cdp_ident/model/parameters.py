# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The physical parameters of the model, their nominal values and ranges, and the base parameters.

A zero-input motion depends on the nine physical parameters only through five numbers, the *base parameters* (in code,
`GROUPS`; on ROS, `groups.*`): multiplying all masses, inertias and frictions by one factor changes no motion. Those
five, with the length L and gravity g, are the *coefficients* that the equations of motion work with.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import OptionError


def time_unit(length: float, gravity: float) -> float:
    """Return a rig's own unit of time sqrt(L / g) [s]."""
    return float(np.sqrt(length / gravity))


@dataclass(frozen=True)
class Parameter:
    """One physical parameter: the paper's symbol, what it is, and its search range as factors on the nominal value."""

    symbol: str
    description: str
    unit: str
    nominal: float
    """The paper's estimate (Table 2)."""
    lower_factor: float = 1.0
    upper_factor: float = 1.0


PARAMETERS = (
    # The factors are Eq. (9)'s over Table 2's, rounded, its two lines exchanged (L is printed above U), and the lower
    # ones of c1 and c2 a tenth of the printed: the paper's own results (Tables 4 and 5) lie below those.
    Parameter("m1", "mass of the inner rod", "kg", 0.108, 0.5, 2.0),
    Parameter("m2", "mass of the outer rod", "kg", 0.108, 0.5, 2.0),
    Parameter("m0", "mass of the encoder at the joint between the rods", "kg", 0.208, 0.5, 2.0),
    Parameter("l1", "distance from the cart's joint to the inner rod's centre of mass", "m", 0.2, 0.9, 1.8),
    Parameter("l2", "distance from the joint between the rods to the outer rod's centre of mass", "m", 0.2, 0.6, 1.2),
    Parameter("J1", "moment of inertia of the inner rod about its centre of mass", "kg m^2", 0.00133, 0.5, 2.0),
    Parameter("J2", "moment of inertia of the outer rod about its centre of mass", "kg m^2", 0.00133, 0.5, 2.0),
    Parameter("c1", "rotational friction of the cart's joint", "N m s", 0.00705, 0.05, 5.0),
    Parameter("c2", "rotational friction of the joint between the rods", "N m s", 0.00305, 0.05, 5.0),
)
"""The parameters that are searched for, in the order of the chromosome (Eq. 8, whose second m1 is m2)."""

CONSTANTS = (
    Parameter("L", "distance between the two joints", "m", 0.4, 0.0125, 25.0),
    Parameter("g", "acceleration of gravity", "m/s^2", 9.81, 0.01, 10.0),
)
"""Parameters that are known beforehand and not searched for; beyond the factors they are in other units."""

INERTIA = Parameter(
    "A22",
    "inertia about the cart's joint, m1 l1^2 + J1 + (m2 + m0) L^2",
    "kg m^2",
    0.108 * 0.2**2 + 0.00133 + (0.108 + 0.208) * 0.4**2,
)
"""A free swing shows masses, inertias and frictions only relative to it; trials with known weights determine it."""

SYMBOLS = tuple(parameter.symbol for parameter in PARAMETERS)
NOMINAL = {parameter.symbol: parameter.nominal for parameter in (*PARAMETERS, *CONSTANTS)}
LARGEST = 1e12
"""More than any parameter of a pendulum is in SI units; products of three of them are still numbers."""


@dataclass(frozen=True)
class Group:
    """One of the base parameters, which a zero-input trial determines."""

    symbol: str
    formula: str
    unit: str


GROUPS = (
    Group("A23_over_A22", "m2 L l2 / A22", "1"),
    Group("A33_over_A22", "(m2 l2^2 + J2) / A22", "1"),
    Group("a1_over_A22", "(m1 l1 + (m2 + m0) L) / A22", "1/m"),
    Group("c1_over_A22", "c1 / A22", "1/s"),
    Group("c2_over_A22", "c2 / A22", "1/s"),
)
"""The five base parameters, all relative to A22 = m1 l1^2 + J1 + (m2 + m0) L^2, the inertia about the cart's joint."""

INVERSE_INERTIA = Group("one_over_A22", "1 / A22", "1/(kg m^2)")
"""What trials with and without a known weight determine beside the base parameters."""

COEFFICIENTS = (*(group.symbol for group in GROUPS), "L", "g")
"""Parameters of the equations of motion, in the order in which compiled code takes them."""


def inertia_about_cart(physical: Array, length: float) -> Array:
    """Return A22 = m1 l1^2 + J1 + (m2 + m0) L^2 [kg m^2] of chromosomes (..., 9)."""
    m1, m2, m0, l1, _, J1, *_ = np.moveaxis(np.asarray(physical, dtype=float), -1, 0)
    return np.asarray(m1 * l1**2 + J1 + (m2 + m0) * length**2)


def groups_of(physical: Array, length: float) -> Array:
    """Return the five base parameters (..., 5) of chromosomes (..., 9), for the length L [m]."""
    m1, m2, m0, l1, l2, _, J2, c1, c2 = np.moveaxis(np.asarray(physical, dtype=float), -1, 0)
    A22 = inertia_about_cart(physical, length)
    return np.stack([m2 * length * l2, m2 * l2**2 + J2, m1 * l1 + (m2 + m0) * length, c1, c2], axis=-1) / A22[..., None]


def coefficients_of(groups: Array, length: float, gravity: float) -> Array:
    """Return the coefficients (..., 7) of base parameters (..., 5), for the length L [m] and gravity g [m/s^2]."""
    groups = np.asarray(groups, dtype=float)
    constants = np.broadcast_to([length, gravity], (*groups.shape[:-1], 2))
    return np.concatenate([groups, constants], axis=-1)


def physical_coefficients(values: Mapping[str, float]) -> Array:
    """Return the coefficients (7,) of one set of physical values by symbol: the chromosome's, L and g.

    Raises:
        OptionError: a symbol is missing, or the values describe no mechanism.
    """
    missing = [symbol for symbol in NOMINAL if symbol not in values]
    if missing:
        raise OptionError(f"parameters {', '.join(missing)} are missing: all of {', '.join(NOMINAL)} are needed")
    physical, length = np.array([values[symbol] for symbol in SYMBOLS]), values["L"]
    negative = [symbol for symbol in SYMBOLS if symbol not in ("l1", "l2") and values[symbol] < 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        coefficients = coefficients_of(groups_of(physical, length), length, values["g"])
    coupling, outer_inertia = coefficients[:2]
    if negative or not np.all(np.isfinite(coefficients)) or outer_inertia <= coupling**2 or length <= 0:
        raise OptionError(
            "these parameters describe no mechanism: no mass, inertia or friction may be negative, L must be positive, "
            f"and A22 A33 > A23^2; they are {', '.join(f'{symbol} = {values[symbol]:g}' for symbol in NOMINAL)}"
        )
    return coefficients
