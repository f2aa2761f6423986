# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What was hidden in an emulated rig beside what was found."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.rig.emulator.configuration import load_rig
from cdp_ident.yaml_file import read_yaml


class Compared(NamedTuple):
    """One number of the rig; None where it has not, or was not found to have, such a number."""

    name: str
    unit: str
    hidden: float | None
    found: float | None


def compare(rig: Path, report: dict[str, Any]) -> Iterator[Compared]:
    """Yield the five base parameters and then the effects of a rig's file and of `report.json`.

    Torques are given over A22, as the base parameters are: a free swing shows no more of them.
    """
    truth = load_rig(rig).parameters
    actual = np.array([truth[symbol] for symbol in SYMBOLS])
    for group, value in zip(GROUPS, groups_of(actual, truth["L"]), strict=True):
        found = report["after"]["groups"][group.symbol]["value"]
        yield Compared(group.formula, "" if group.unit == "1" else group.unit, float(value), found)
    hidden = {
        (joint, name, parameter): value
        for name, joints in read_yaml(rig).get("effects", {}).items()
        for joint, values in joints.items()
        for parameter, value in values.items()
    }
    found_effects = {
        (effect["joint"], effect["name"], parameter): quantity["value"]
        for effect in report["effects"]
        for parameter, quantity in effect["parameters"].items()
    }
    sides = (
        (hidden, float(inertia_about_cart(actual, truth["L"]))),
        (found_effects, report["after"]["physical"]["A22"]["value"]),
    )
    known = {(str(effect.joint), effect.name, p.name): p for effect in known_effects() for p in effect.parameters}
    for key in dict.fromkeys((*hidden, *found_effects)):
        description = known.get(key)
        if description is None or description.fixed:  # it only says which form of the effect is meant
            continue
        joint, name, parameter = key
        label, unit, power = (
            f"{name.replace('_', ' ')}, {joint}: {parameter}",
            description.unit,
            description.inertia_power,
        )
        if power:
            label, unit = f"{label} / A22{'' if power == 1 else f'^{power}'}", f"{unit}, over A22's"
        values = (of[key] / description.scale(inertia) if key in of else None for of, inertia in sides)
        yield Compared(label, unit, *values)
