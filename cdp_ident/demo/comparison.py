# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What came of a demonstration, and what was hidden in the emulated rig beside it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console

from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.outside_text import shown
from cdp_ident.report.document import Table, print_table
from cdp_ident.report.folder import PAGE
from cdp_ident.report.searches import shown_generations
from cdp_ident.rig.emulator.configuration import load_rig
from cdp_ident.yaml_file import read_yaml


def print_result(console: Console, report: dict[str, Any]) -> None:
    """Print how the search went, and what the models leave of the trial that was held out."""
    history = report["search"]["history"]
    generations = shown_generations(len(history) - 1)
    best = ("E(Z) [rad²]", *(f"{history[generation]:.4g}" for generation in generations))
    console.print(f"The improved genetic algorithm's best error, which {PAGE} draws as a curve:")
    print_table(console, Table("", ("generation", *map(str, generations)), [best]))
    console.print()
    before, after = (report[stage]["error"]["holdout"] for stage in ("before", "after"))
    console.print(report["verdict"])
    console.print("\nOn the trial that no fit has seen, measured against simulated:")
    for name, error in (("the paper's model, fitted", before), ("with the effects found", after)):
        rmse, free_run = 1e3 * error["rmse_rad"], error["sse_free_run"]
        eq10 = "diverges" if free_run is None else f"{free_run:.4g} rad²"
        console.print(f"  {name:<26} {rmse:8.4g} mrad over {error['window_s']:.3g} s   Eq. (10) {eq10}")
    noise = report["noise_rad"]
    console.print(f"  the encoders' noise        {1e3 * noise['theta1']:8.4g} and {1e3 * noise['theta2']:.4g} mrad")


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
        label, unit = f"{name.replace('_', ' ')}, {joint}: {parameter}", description.unit
        if power := description.inertia_power:
            label, unit = f"{label} / A22{'' if power == 1 else f'^{power}'}", f"{unit}, over A22's"
        values = (of[key] / description.scale(inertia) if key in of else None for of, inertia in sides)
        yield Compared(label, unit, *values)


def print_comparison(console: Console, rig: Path, report: dict[str, Any]) -> None:
    """Print what was hidden in a rig beside what was found."""
    rows = []
    for name, unit, hidden, found in compare(rig, report):
        off = f"{100 * abs(found / hidden - 1):.2g} %" if hidden and found is not None else ""
        rows.append((name, *("nothing" if value is None else f"{value:.6g}" for value in (hidden, found)), off, unit))
    console.print(f"identify did not read {shown(rig)}, which has the true values:", soft_wrap=True)
    print_table(console, Table("", ("", "hidden in the rig", "found", "off by", "unit"), rows))
    console.print(
        "\nTorques stand over A22 here, as the base parameters do: a free swing does not show by which factor all "
        "masses,\ninertias and torques are larger or smaller. In N m they are given for the masses nearest to the "
        "nominal ones."
    )
