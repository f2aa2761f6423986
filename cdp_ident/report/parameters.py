# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters with their intervals: against what was known before, with each other, and from trial to trial."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS, SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.report.document import Charts, Parts, Row, Sentences, Table
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

_FITTED = ("fitted ± std", "95 % interval", "unit")
_FELT, _MOST_IN_DOUBT = 0.5, 3
"""Effects in doubt are mentioned if they make half of a standard deviation, and at most so many."""
_Shown = tuple[str, Colour, str, Section]
"""Label, colour and shape of quantities, and these by their names."""


def parameters(report: Section) -> Parts:
    """Return the chapter: base parameters, physical values, what the trials determine, and each trial alone."""
    after, compared, nominal = report["after"], report["repeatability"], nominal_values(report)
    trials = compared["trials"] if compared else ()
    agree = "agree" if compared and compared["agree"] else "do not agree"
    estimates = (after["groups"], *(trial["groups"] for trial in trials))
    return (
        base_parameters(report),
        Table(
            "Physical values",
            ("parameter", "what it is", "nominal", *_FITTED, "determined by the trials"),
            [
                (
                    parameter.symbol,
                    parameter.description,
                    f"{nominal[parameter.symbol]:.4g}",
                    *_fitted(after["physical"][parameter.symbol], 0.0),
                    how_determined(report, parameter.symbol),
                )
                for parameter in (*PARAMETERS, *CONSTANTS, INERTIA)
            ],
            wide=("what it is",),
        ),
        Sentences.of(determined_words(report), "What the trials determine"),
        Table(
            f"Each trial alone: they {agree} (p = {compared['p_value']:.2g})" if compared else "",
            ("base parameter", "jointly", *(trial["trial"] for trial in trials)),
            [
                (short_name(group), *(with_std(of[group]["value"], of[group]["std"]) for of in estimates))
                for group in (after["groups"] if trials else ())
            ],
        ),
        Charts([against_nominal(report), *correlation(report), *repeatability(report)], side_by_side=True),
    )


def base_parameters(report: Section, short: bool = False) -> Table:
    """Return the base parameters of the final model; in `short`, with their units beside the values."""
    nominal, rows = nominal_values(report), []
    for group in GROUPS:
        found = report["after"]["groups"][group.symbol]
        name, sure = group_words(group), "yes" if found["determined"] else "not by these trials"
        beside = in_unit(found["value"], found["std"], found["unit"])
        rows.append((name, *((beside,) if short else (f"{nominal[group.symbol]:.4g}", *_fitted(found))), sure))
    columns = ("base parameter", *(_FITTED[:1] if short else ("nominal", *_FITTED)), "determined")
    return Table("Base parameters, all that a free swing depends on", columns, rows)


def _fitted(quantity: Section, lowest: float = -math.inf) -> Row:
    """Return what stands in the columns of a fitted value, which is not below the `lowest`."""
    value = (quantity["value"], quantity["std"])
    return with_std(*value), interval(*value, lowest) if value[1] else "", unit(quantity["unit"])


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
    after, nominal = report["after"], nominal_values(report)
    undetermined = [symbol for symbol, quantity in after["physical"].items() if not quantity["determined"]]
    ratios = (f"{short_name(s)} {q['value'] / nominal[s]:.4g}" for s, q in after["groups"].items() if nominal[s])
    return Figure(
        "parameters",
        "Parameters against nominal",
        "Fitted over nominal value, with 95 % intervals. Hollow: not determined by the trials; of the values that fit "
        "equally well, the ones nearest to nominal.",
        f"Base parameters of the final model over nominal: {', '.join(ratios)}. Not determined: "
        f"{', '.join(undetermined) or 'none'}.",
        [
            _over_nominal(report, "groups", nominal, "base parameters, all that a free swing shows"),
            _over_nominal(report, "physical", nominal, "physical values"),
        ],
    )


def _over_nominal(report: Section, kind: str, nominal: Mapping[str, float], title: str) -> Panel:
    reference = {
        name: nominal[name]
        for name, quantity in report["after"][kind].items()
        if nominal[name] and (kind == "groups" or quantity["std"] != 0.0)  # as a physical value that is given has
    }
    shapes = {"before": "diamond", "after": "circle"}
    shown = [(model.label, model.key, shapes[model.key], report[model.key][kind]) for model in models(report)]
    names, height = named(map(short_name, reference)), 60.0 + 30.0 * len(reference)
    marks = [level("nominal", "noise", 1.0, names), *_against(reference, shown, 0.3)]
    return Panel(Axis("fitted / nominal"), names, marks, title, height)


def _against(
    reference: Mapping[str, float], shown: Sequence[_Shown], apart: float, unit: float = 1.0, origin: float = 0.0
) -> Iterator[Line]:
    """Yield quantities over their reference values, as so many units from an origin."""
    for index, (label, colour, shape, quantities) in enumerate(shown):
        of = [quantities[name] for name in reference]
        pairs = list(zip(of, reference.values(), strict=True))
        yield Line(
            label,
            colour,
            np.array([unit * (quantity["value"] / value - origin) for quantity, value in pairs]),
            np.array(beside(index, len(shown), apart, len(reference))),
            0.0,
            shape=shape,
            size=9.0,
            hollow=[not quantity.get("determined", True) for quantity in of],
            half_widths=[unit * CONFIDENCE * quantity["std"] / abs(value) for quantity, value in pairs],
            words=[in_unit(quantity["value"], quantity["std"], quantity.get("unit", "")) for quantity in of],
        )


def correlation(report: Section) -> Iterator[Figure]:
    """Yield how the errors of the final model's estimates go together."""
    found = report["after"]["correlation"]
    short = [short_name(name) for name in found["names"]]
    matrix = np.array(found["matrix"])
    matrix = np.where(np.isfinite(matrix), matrix, np.nan)
    rows, columns = np.nonzero(np.tril(np.isfinite(matrix), -1))
    strongest = sorted(zip(abs(matrix[rows, columns]), rows, columns, strict=True), reverse=True)[:3]
    said = "; ".join(f"{short[i]} with {short[j]}: {matrix[i, j]:.2f}" for _, i, j in strongest)
    numbers = named(str(place) for place, _ in enumerate(short, start=1))
    beside_names = named(f"{wrapped(name)}  {place}" for place, name in enumerate(short, start=1))
    yield Figure(
        "correlation",
        "Correlation of the estimates",
        "Of the final model: near 1 or -1, the errors of two estimates go together, and the trials hardly distinguish "
        "the two.",
        f"Strongest correlations: {said or 'none'}.",
        [Panel(numbers, beside_names, [Heat(matrix)], height=40.0 + 36.0 * len(short))],
    )


def repeatability(report: Section) -> Iterator[Figure]:
    """Yield each trial's own estimate against the joint one, where there are several trials."""
    if compared := report["repeatability"]:
        agree = "agree" if compared["agree"] else "do not agree"
        yield estimates_against(
            report["after"]["groups"],
            [(trial["trial"], trial["groups"]) for trial in compared["trials"]],
            ("difference from the joint fit [%]", "joint fit"),
            "repeatability",
            "Each trial alone",
            "Each trial's own fit of the model with its effects against the joint one, with 95 % intervals. Trials "
            f"{agree} (p = {compared['p_value']:.2g}).",
        )


def runs_compared(runs: Mapping[str, Section]) -> Figure:
    """Return the base parameters of several reports, by name, against those of the first."""
    estimates = [(name, report["after"]["groups"]) for name, report in runs.items()]
    first, joint = estimates[0]
    return estimates_against(
        joint,
        estimates,
        (f"difference from {first} [%]", "no difference"),
        "compare_groups",
        f"Base parameters against those of {first}",
        "Of each final model, with 95 % intervals.",
    )


def estimates_against(
    joint: Section,
    estimates: Sequence[tuple[str, Section]],
    labels: tuple[str, str],
    name: str,
    title: str,
    caption: str,
) -> Figure:
    """Return a figure of estimates of several trials or runs, as their relative difference from a joint one.

    `labels` are those of the axis and of no difference.
    """
    values = {symbol: quantity["value"] for symbol, quantity in joint.items()}
    reference = {symbol: value for symbol, value in values.items() if value and np.isfinite(value)}
    shown = [(trial, *series(index), quantities) for index, (trial, quantities) in enumerate(estimates)]
    marks = list(_against(reference, shown, 0.6 / max(len(estimates), 2), 100.0, 1.0))
    said = "; ".join(
        f"{mark.label}: {', '.join(f'{short_name(n)} {d:+.2g} %' for n, d in zip(reference, mark.x, strict=True))}"
        for mark in marks
    )
    names, height = named(map(short_name, reference)), 60.0 + max(34.0, 13.0 * len(estimates)) * len(reference)
    panel = Panel(Axis(labels[0]), names, [level(labels[1], "noise", 0.0, names), *marks], height=height)
    return Figure(name, title, caption, f"{title}. {said}.", [panel])
