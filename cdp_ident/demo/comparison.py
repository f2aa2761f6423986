# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What came of a demonstration, and what was hidden in the emulated rig beside it."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from rich.console import Console

from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.parameters import GROUPS
from cdp_ident.outside_text import shown
from cdp_ident.pipeline.searches_page import shown_generations
from cdp_ident.report.document import Table, print_table
from cdp_ident.report.folder import PAGE
from cdp_ident.report.schema import Section
from cdp_ident.rig.emulator.configuration import EmulatedRig, load_rig


def print_result(console: Console, report: Section) -> None:
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
        eq10 = f"{free_run:.4g} rad²" if math.isfinite(free_run) else "diverges"
        console.print(f"  {name:<26} {rmse:8.4g} mrad over {error['window_s']:.3g} s   Eq. (10) {eq10}")
    noise = report["noise_rad"]
    console.print(f"  the encoders' noise        {1e3 * noise['theta1']:8.4g} and {1e3 * noise['theta2']:.4g} mrad")


class Compared(NamedTuple):
    """One number of the rig; None where it has not, or was not found to have, such a number."""

    name: str
    unit: str
    hidden: float | None
    found: float | None


def compare(rig: EmulatedRig, report: Section) -> Iterator[Compared]:
    """Yield the five base parameters and then the effects of a rig and of `report.json`.

    Torques are given over A22, as the base parameters are: a free swing shows no more of them.
    """
    for group, value in zip(GROUPS, rig.coefficients().tolist(), strict=False):
        found = report["after"]["groups"][group.symbol]["value"]
        yield Compared(group.formula, "" if group.unit == "1" else group.unit, value, found)
    known = {(effect.joint, effect.name, p.name): p for effect in known_effects() for p in effect.parameters}
    hidden = {
        (effect.joint, effect.name, parameter.name): value
        for effect, values in rig.effects.each()
        for parameter, value in zip(effect.parameters, values, strict=True)
    }
    found_effects = {
        (effect["joint"], effect["name"], parameter): quantity["as_fitted"]["value"]
        for effect in report["effects"]
        for parameter, quantity in effect["parameters"].items()
    }
    for key in dict.fromkeys((*hidden, *found_effects)):
        description = known.get(key)
        if description is None or description.fixed:  # it only says which form of the effect is meant
            continue
        joint, name, parameter = key
        label, unit = f"{name.replace('_', ' ')}, {joint}: {parameter}", description.unit
        if power := description.inertia_power:
            label, unit = f"{label} / A22{'' if power == 1 else f'^{power}'}", f"{unit}, over A22's"
        yield Compared(label, unit, hidden.get(key), found_effects.get(key))


def print_comparison(console: Console, rig: Path, report: Section) -> None:
    """Print what was hidden in a rig beside what was found."""
    rows = []
    for name, unit, hidden, found in compare(load_rig(rig), report):
        off = f"{100 * abs(found / hidden - 1):.2g} %" if hidden and found is not None else ""
        rows.append((name, *("nothing" if value is None else f"{value:.6g}" for value in (hidden, found)), off, unit))
    console.print(f"identify did not read {shown(rig)}, which has the true values:", soft_wrap=True)
    print_table(console, Table("", ("", "hidden in the rig", "found", "off by", "unit"), rows))
    console.print(
        "\nTorques stand over A22 here, as the base parameters do: a free swing does not show by which factor all "
        "masses,\ninertias and torques are larger or smaller. In N m they are given for the masses nearest to the "
        "nominal ones."
    )
