# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters with their intervals: against what was known before, with each other, and from trial to trial."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS, SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.report.document import Charts, Parts, Sentences, Table
from cdp_ident.report.figures.description import (
    Axis,
    Colour,
    Figure,
    Heat,
    Line,
    Panel,
    beside,
    level,
    named,
    series,
    wrapped,
)
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import group_words, in_unit, interval, key_words, models, short_name, unit, with_std

_FELT, _MOST_IN_DOUBT = 0.5, 3
"""Effects in doubt are mentioned if they make half of a standard deviation, and at most so many."""
_Shown = tuple[str, Colour, str, Section]
"""Label, colour and shape of quantities, and these by their names."""


def parameters(report: Section) -> Parts:
    """Return the chapter: base parameters, physical values, what the trials determine, and each trial alone."""
    after, compared = report["after"], report["repeatability"]
    trials = compared["trials"] if compared else ()
    estimates = (after["groups"], *(trial["groups"] for trial in trials))
    alone = [
        (short_name(group), *(with_std(of[group]["value"], of[group]["std"]) for of in estimates))
        for group in (after["groups"] if trials else ())
    ]
    columns = {
        "parameter": lambda parameter: parameter.symbol,
        "what it is": lambda parameter: parameter.description,
        **_values(after["physical"], nominal_values(report), lowest=0.0),
        "determined by the trials": lambda parameter: how_determined(report, parameter.symbol),
    }
    return (
        base_parameters(report),
        Table.of("Physical values", (*PARAMETERS, *CONSTANTS, INERTIA), columns, wide=("what it is",)),
        Sentences.of(determined_words(report), "What the trials determine"),
        Table(
            f"Each trial alone: they {_agreement(compared)}" if compared else "",
            ("base parameter", "jointly", *(trial["trial"] for trial in trials)),
            alone,
        ),
        Charts([against_nominal(report), correlation(report), *repeatability(report)], side_by_side=True),
    )


def base_parameters(report: Section, short: bool = False) -> Table:
    """Return the base parameters of the final model; in `short`, with their units beside the values."""
    found = report["after"]["groups"]
    beside_unit = {"fitted ± std": lambda group: in_unit(*(found[group.symbol][of] for of in ("value", "std", "unit")))}
    columns = {
        "base parameter": group_words,
        **(beside_unit if short else _values(found, nominal_values(report))),
        "determined": lambda group: "yes" if found[group.symbol]["determined"] else "not by these trials",
    }
    return Table.of("Base parameters, all that a free swing depends on", GROUPS, columns)


def _values(found: Section, nominal: Section, lowest: float = -np.inf) -> dict[str, Callable[[Any], str]]:
    """Return the columns of nominal and fitted values; the latter are not below the `lowest`."""

    def value(parameter: Any) -> tuple[float, float]:
        return found[parameter.symbol]["value"], found[parameter.symbol]["std"]

    return {
        "nominal": lambda parameter: f"{nominal[parameter.symbol]:.4g}",
        "fitted ± std": lambda parameter: with_std(*value(parameter)),
        "95 % interval": lambda parameter: interval(*value(parameter), lowest) if value(parameter)[1] else "",
        "unit": lambda parameter: unit(found[parameter.symbol]["unit"]),
    }


def _agreement(compared: Section) -> str:
    return f"{'agree' if compared['agree'] else 'do not agree'} (p = {compared['p_value']:.2g})"


def nominal_values(report: Section) -> dict[str, float]:
    """Return what was known of all parameters before, by symbol: measured values, or else nominal ones."""
    options = report["run"]["options"]
    values = {constant.symbol: float(options[constant.symbol]) for constant in CONSTANTS}
    for symbol in SYMBOLS:
        known = options.get(f"known.{symbol}")
        values[symbol] = float(options[f"nominal.{symbol}"] if known is None else known)
    rods, length = np.array([values[symbol] for symbol in SYMBOLS]), values["L"]
    groups = zip(GROUPS, groups_of(rods, length).tolist(), strict=True)
    return {
        **values,
        INERTIA.symbol: float(inertia_about_cart(rods, length)),
        **{group.symbol: value for group, value in groups},
    }


def how_determined(report: Section, symbol: str) -> str:
    """Say how the model that a report ends with came to the value of a physical parameter."""
    quantity = report["after"]["physical"][symbol]
    if quantity["std"] == 0.0:
        return "given"
    if report["run"]["options"].get(f"known.{symbol}") is not None:
        return "measured"
    return "yes" if quantity["determined"] else "no: nearest to nominal"


def determined_words(report: Section) -> list[str]:
    """Say what the trials determine, and what they neither show nor exclude that would change base parameters."""
    groups, in_doubt = report["after"]["groups"], []
    for effect in report["in_doubt"]:
        changed = []
        for group in GROUPS:
            value, std = (groups[group.symbol][of] for of in ("value", "std"))
            change = effect["changes"][group.symbol]
            if value and effect["weight"] * change**2 > (_FELT * std) ** 2:
                changed.append(f"{group.formula} by {100.0 * change / abs(value):+.2g} %")
        if changed:
            in_doubt.append(
                f"{key_words(effect['effect'])}, is neither shown nor excluded; it would change {', '.join(changed)}, "
                "and intervals allow for that"
            )
    return [*report["identifiability"]["words"], *in_doubt[:_MOST_IN_DOUBT]]


def against_nominal(report: Section) -> Figure:
    """Return base parameters and physical values over the nominal ones."""
    after, nominal, panels = report["after"], nominal_values(report), []
    for kind, title in (("groups", "base parameters, all that a free swing shows"), ("physical", "physical values")):
        given = [name for name, quantity in after[kind].items() if kind == "physical" and quantity["std"] == 0.0]
        reference = {name: nominal[name] for name in after[kind] if nominal[name] and name not in given}
        shapes = {"before": "diamond", "after": "circle"}
        shown = [(model.label, model.key, shapes[model.key], report[model.key][kind]) for model in models(report)]
        panels.append(_against(reference, shown, "fitted / nominal", "nominal", title))
    return Figure(
        "parameters",
        "Parameters against nominal",
        "Fitted over nominal value, with 95 % intervals. Hollow: not determined by the trials; of the values that fit "
        "equally well, the ones nearest to nominal.",
        panels,
    )


def _against(
    reference: Mapping[str, float], shown: Sequence[_Shown], label: str, of_reference: str, title: str = ""
) -> Panel:
    """Return quantities over their reference values or, under a label in per cent, as their difference from these."""
    unit, origin = (100.0, 1.0) if label.endswith("[%]") else (1.0, 0.0)
    names = named(map(short_name, reference))
    marks = [level(of_reference, "noise", 1.0 - origin, names)]
    for index, (name, colour, shape, quantities) in enumerate(shown):
        of = [quantities[symbol] for symbol in reference]
        pairs = list(zip(of, reference.values(), strict=True))
        places = beside(index, len(shown), 0.6 / max(len(shown), 2), len(reference))
        mark = Line(
            name,
            colour,
            np.array([unit * (quantity["value"] / value - origin) for quantity, value in pairs]),
            np.array(places),
            0.0,
            shape=shape,
            size=9.0,
            hollow=[not quantity.get("determined", True) for quantity in of],
            half_widths=[unit * CONFIDENCE * quantity["std"] / abs(value) for quantity, value in pairs],
            words=[in_unit(quantity["value"], quantity["std"], quantity.get("unit", "")) for quantity in of],
        )
        marks.append(mark)
    room = max(34.0 if origin else 30.0, 13.0 * len(shown))
    return Panel(Axis(label), names, marks, title, 60.0 + room * len(reference))


def correlation(report: Section) -> Figure:
    """Return how the errors of the final model's estimates go together."""
    found = report["after"]["correlation"]
    short, matrix = [short_name(name) for name in found["names"]], np.array(found["matrix"])
    matrix = np.where(np.isfinite(matrix), matrix, np.nan)
    numbers = named(str(place) for place, _ in enumerate(short, start=1))
    beside_names = named(f"{wrapped(name)}  {place}" for place, name in enumerate(short, start=1))
    return Figure(
        "correlation",
        "Correlation of the estimates",
        "Of the final model: near 1 or -1, the errors of two estimates go together, and the trials hardly distinguish "
        "the two.",
        [Panel(numbers, beside_names, [Heat(matrix)], height=40.0 + 36.0 * len(short))],
    )


def repeatability(report: Section) -> Iterator[Figure]:
    """Yield each trial's own estimate against the joint one, where there are several trials."""
    if compared := report["repeatability"]:
        estimates = [(trial["trial"], trial["groups"]) for trial in compared["trials"]]
        caption = (
            "Each trial's own fit of the model with its effects against the joint one, with 95 % intervals. Trials "
            f"{_agreement(compared)}."
        )
        about = ("repeatability", "Each trial alone", caption)
        yield estimates_against(report["after"]["groups"], "the joint fit", estimates, "joint fit", about)


def runs_compared(runs: Mapping[str, Section]) -> Figure:
    """Return the base parameters of several reports, by name, against those of the first."""
    estimates = [(name, report["after"]["groups"]) for name, report in runs.items()]
    first, joint = estimates[0]
    about = ("compare_groups", f"Base parameters against those of {first}", "Of each final model, with 95 % intervals.")
    return estimates_against(joint, first, estimates, "no difference", about)


def estimates_against(
    joint: Section, its_name: str, estimates: Sequence[tuple[str, Section]], none: str, about: tuple[str, str, str]
) -> Figure:
    """Return a figure of estimates of several trials or runs, as their relative difference from a joint one.

    `none` is what no difference is called; `about` the figure's name, title and caption.
    """
    reference = {s: quantity["value"] for s, quantity in joint.items() if abs(quantity["value"]) not in (0.0, np.inf)}
    shown = [(trial, *series(index), quantities) for index, (trial, quantities) in enumerate(estimates)]
    panel = _against(reference, shown, f"difference from {its_name} [%]", none)
    return Figure(*about, [panel])
