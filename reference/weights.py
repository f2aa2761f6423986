# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rod with a weight clamped to it is one rigid body: its mass, centre and inertia by the parallel axis theorem."""

from collections.abc import Mapping

_OF_ROD = {"inner": ("m1", "l1", "J1"), "outer": ("m2", "l2", "J2")}


def with_weight(
    values: Mapping[str, float], rod: str, mass: float, place: float, inertia: float = 0.0
) -> dict[str, float]:
    """Return the physical values of a pendulum with a weight on a rod.

    Args:
        values: the physical values of all `SYMBOLS`.
        rod: inner or outer.
        mass: of the weight [kg].
        place: distance of its centre of mass from the rod's joint [m].
        inertia: its own, about its centre of mass [kg m^2].
    """
    m, l, J = _OF_ROD[rod]  # noqa: E741 - the paper's symbol
    whole = values[m] + mass
    centre = (values[m] * values[l] + mass * place) / whole
    about = values[J] + values[m] * (values[l] - centre) ** 2 + inertia + mass * (place - centre) ** 2
    return {**values, m: whole, l: centre, J: about}
