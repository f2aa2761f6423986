# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters with their intervals: against nominal, with each other, and from trial to trial."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.report.figures.description import Axis, Figure, Heat, Line, Panel, beside, level, named
from cdp_ident.report.figures.errors import wrapped
from cdp_ident.report.figures.palette import Colour, series
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import in_unit, models, nominal_groups, nominal_value, short_name

_Shown = tuple[str, Colour, str, Section]
"""Label, colour and shape of quantities, and these by their names."""


def against_nominal(report: Section) -> Figure:
    """Return base parameters and physical values over the nominal ones."""
    after, groups = report["after"], nominal_groups(report)
    physical = {
        symbol: nominal_value(report, symbol)
        for symbol, quantity in after["physical"].items()
        if quantity["std"] != 0.0  # as one that is given has
    }
    undetermined = [symbol for symbol, quantity in after["physical"].items() if not quantity["determined"]]
    ratios = (f"{short_name(s)} {q['value'] / groups[s]:.4g}" for s, q in after["groups"].items() if groups[s])
    return Figure(
        "parameters",
        "Parameters against nominal",
        "Fitted over nominal value, with 95 % intervals. Hollow: not determined by the trials; of the values that fit "
        "equally well, the ones nearest to nominal.",
        f"Base parameters of the final model over nominal: {', '.join(ratios)}. Not determined: "
        f"{', '.join(undetermined) or 'none'}.",
        [
            _over_nominal(report, "groups", groups, "base parameters, all that a free swing shows"),
            _over_nominal(report, "physical", physical, "physical values"),
        ],
    )


def _over_nominal(report: Section, kind: str, nominal: Mapping[str, float], title: str) -> Panel:
    reference = {name: value for name, value in nominal.items() if value}
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
    names = [wrapped(name) for name in short]
    matrix = np.array(found["matrix"])
    matrix = np.where(np.isfinite(matrix), matrix, np.nan)
    rows, columns = np.nonzero(np.tril(np.isfinite(matrix), -1))
    strongest = sorted(zip(abs(matrix[rows, columns]), rows, columns, strict=True), reverse=True)[:3]
    said = "; ".join(f"{short[i]} with {short[j]}: {matrix[i, j]:.2f}" for _, i, j in strongest)
    numbers = named(str(place) for place, _ in enumerate(names, start=1))
    beside_names = named(f"{name}  {place}" for place, name in enumerate(names, start=1))
    yield Figure(
        "correlation",
        "Correlation of the estimates",
        "Of the final model: near 1 or -1, the errors of two estimates go together, and the trials hardly distinguish "
        "the two.",
        f"Strongest correlations: {said or 'none'}.",
        [Panel(numbers, beside_names, [Heat(matrix)], height=40.0 + 36.0 * len(names))],
    )


def repeatability(report: Section) -> Iterator[Figure]:
    """Yield each trial's own estimate against the joint one, where there are several trials."""
    compared = report["repeatability"]
    if compared is None:
        return
    yield estimates_against(
        [(trial["trial"], trial["groups"]) for trial in compared["trials"]],
        report["after"]["groups"],
        Figure(
            "repeatability",
            "Each trial alone",
            "Each trial's own fit of the model with its effects against the joint one, with 95 % intervals. Trials "
            f"{'agree' if compared['agree'] else 'do not agree'} (p = {compared['p_value']:.2g}).",
            "",
            (),
        ),
        "difference from the joint fit [%]",
        "joint fit",
    )


def runs_compared(runs: Mapping[str, Section]) -> Figure:
    """Return the base parameters of several reports, by name, against those of the first."""
    estimates = [(name, report["after"]["groups"]) for name, report in runs.items()]
    first, joint = estimates[0]
    title = f"Base parameters against those of {first}"
    figure = Figure("compare_groups", title, "Of each final model, with 95 % intervals.", "", ())
    return estimates_against(estimates, joint, figure, f"difference from {first} [%]", "no difference")


def estimates_against(
    estimates: Sequence[tuple[str, Section]], joint: Section, figure: Figure, label: str, origin: str
) -> Figure:
    """Complete a figure with estimates of several trials or runs, as their relative difference from a joint one."""
    values = {name: quantity["value"] for name, quantity in joint.items()}
    reference = {name: value for name, value in values.items() if value and np.isfinite(value)}
    shown = [(trial, *series(index), quantities) for index, (trial, quantities) in enumerate(estimates)]
    marks = list(_against(reference, shown, 0.6 / max(len(estimates), 2), 100.0, 1.0))
    said = "; ".join(
        f"{mark.label}: {', '.join(f'{short_name(n)} {d:+.2g} %' for n, d in zip(reference, mark.x, strict=True))}"
        for mark in marks
    )
    height = 60.0 + max(34.0, 13.0 * len(estimates)) * len(reference)
    names = named(map(short_name, reference))
    panel = Panel(Axis(label), names, [level(origin, "noise", 0.0, names), *marks], height=height)
    return replace(figure, alternative=f"{figure.title}. {said}.", panels=[panel])
