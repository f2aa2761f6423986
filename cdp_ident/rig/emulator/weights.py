# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Weights on the rods of an emulated rig: each rod and its weight are one body."""

from collections.abc import Iterable, Mapping

from cdp_ident.model.weights import Rod, Weight

_OF_ROD: dict[Rod, tuple[str, str, str]] = {"inner": ("m1", "l1", "J1"), "outer": ("m2", "l2", "J2")}


def with_weights(parameters: Mapping[str, float], weights: Iterable[Weight]) -> dict[str, float]:
    """Return the physical parameters, by the paper's symbols, of a rig whose rods carry weights.

    Masses add up, centres of mass are their means, and inertias are taken to the new centres (Steiner).
    """
    heavier = dict(parameters)
    for weight in weights:
        mass, centre, inertia = _OF_ROD[weight.rod]
        rod_mass, rod_centre = heavier[mass], heavier[centre]
        heavier[mass] = rod_mass + weight.mass
        heavier[centre] = (rod_mass * rod_centre + weight.mass * weight.place) / heavier[mass]
        heavier[inertia] += weight.inertia + rod_mass * weight.mass / heavier[mass] * (rod_centre - weight.place) ** 2
    return heavier
