"""Parameters with their intervals: against nominal, with each other, and from trial to trial."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cdp_ident.diagnosis.identifiability import CONFIDENCE
from cdp_ident.report.comparison import Run
from cdp_ident.report.figures.description import Axis, Figure, Heat, Intervals, Level, Panel
from cdp_ident.report.figures.errors import wrapped
from cdp_ident.report.figures.models import models
from cdp_ident.report.figures.palette import series
from cdp_ident.report.formatting import number, with_std
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import nominal_groups, nominal_value, short_name


def against_nominal(report: Section) -> Figure:
    """Return base parameters and physical values over the nominal ones."""
    physical = {
        symbol: nominal_value(report, symbol)
        for symbol, quantity in report["after"]["physical"].items()
        if quantity["std"] != 0.0  # as one that is given has
    }
    undetermined = [symbol for symbol, quantity in report["after"]["physical"].items() if not quantity["determined"]]
    return Figure(
        "parameters",
        "parameters",
        "Parameters against nominal",
        "Fitted over nominal value, with 95 % intervals. Hollow: not determined by the trials; of the values that fit "
        "equally well, the ones nearest to nominal.",
        "Base parameters of the final model over nominal: "
        + ", ".join(
            f"{short_name(symbol)} {number(quantity['value']) / nominal_groups(report)[symbol]:.4g}"
            for symbol, quantity in report["after"]["groups"].items()
        )
        + f". Not determined: {', '.join(undetermined) or 'none'}.",
        [
            _over_nominal(report, "groups", nominal_groups(report), "base parameters, all that a free swing shows"),
            _over_nominal(report, "physical", physical, "physical values"),
        ],
    )


def _over_nominal(report: Section, kind: str, nominal: Mapping[str, float], title: str) -> Panel:
    shown = models(report)
    names = [name for name, value in nominal.items() if value]
    marks: list[Intervals | Level] = [Level("nominal", "noise", 1.0)]
    for index, model in enumerate(shown):
        offset = (index - (len(shown) - 1) / 2) * 0.3
        quantities = [report[model.key][kind][name] for name in names]
        marks.append(
            Intervals(
                model.label,
                model.colour,
                [place + offset for place in range(len(names))],
                [number(q["value"]) / nominal[name] for name, q in zip(names, quantities, strict=True)],
                [CONFIDENCE * number(q["std"]) / nominal[name] for name, q in zip(names, quantities, strict=True)],
                [not q["determined"] for q in quantities],
                [f"{with_std(q['value'], q['std'])} {q['unit']}" for q in quantities],
                "diamond" if model.key == "before" else "circle",
            )
        )
    ticks = [(float(place), short_name(name)) for place, name in enumerate(names)]
    return Panel(Axis("fitted / nominal"), Axis(ticks=ticks), marks, title, 60.0 + 30.0 * len(names))


def correlation(report: Section) -> Iterator[Figure]:
    """Yield how the errors of the final model's estimates go together."""
    found = report["after"]["correlation"]
    short = [short_name(name) for name in found["names"]]
    names = [wrapped(name) for name in short]
    matrix = np.array([[np.nan if value is None else value for value in row] for row in found["matrix"]])
    pairs = sorted(
        ((abs(matrix[i, j]), i, j) for i in range(len(names)) for j in range(i) if np.isfinite(matrix[i, j])),
        reverse=True,
    )
    strongest = "; ".join(f"{short[i]} with {short[j]}: {matrix[i, j]:.2f}" for _, i, j in pairs[:3])
    numbers = Axis(ticks=[(float(place), str(place + 1)) for place in range(len(names))])
    named = Axis(ticks=[(float(place), f"{name}  {place + 1}") for place, name in enumerate(names)])
    yield Figure(
        "correlation",
        "parameters",
        "Correlation of the estimates",
        "Of the final model: near 1 or -1, the errors of two estimates go together, and the trials hardly distinguish "
        "the two.",
        f"Strongest correlations: {strongest or 'none'}.",
        [Panel(numbers, named, [Heat(names, matrix)], height=40.0 + 36.0 * len(names))],
    )


def repeatability(report: Section) -> Iterator[Figure]:
    """Yield each trial's own estimate against the joint one, where there are several trials."""
    compared = report["repeatability"]
    if compared is None:
        return
    joint = {name: number(quantity["value"]) for name, quantity in report["after"]["groups"].items()}
    yield estimates_against(
        [(trial["trial"], trial["groups"]) for trial in compared["trials"]],
        joint,
        Figure(
            "repeatability",
            "parameters",
            "Each trial alone",
            "Each trial's own fit of the model with its effects against the joint one, with 95 % intervals. Trials "
            f"{'agree' if compared['agree'] else 'do not agree'} (p = {compared['p_value']:.2g}).",
            "",
            (),
        ),
        "difference from the joint fit [%]",
        "joint fit",
    )


def runs_compared(runs: Sequence[Run]) -> Figure:
    """Return the base parameters of several reports against those of the first."""
    first = runs[0]
    groups = {name: number(quantity["value"]) for name, quantity in first.report["after"]["groups"].items()}
    title = f"Base parameters against those of {first.name}"
    figure = Figure("compare_groups", "compare", title, "Of each final model, with 95 % intervals.", "", ())
    estimates = [(run.name, run.report["after"]["groups"]) for run in runs]
    return estimates_against(estimates, groups, figure, f"difference from {first.name} [%]", "no difference")


def estimates_against(
    estimates: Sequence[tuple[str, Section]], reference: Mapping[str, float], figure: Figure, label: str, origin: str
) -> Figure:
    """Complete a figure with estimates of several trials or runs, as their relative difference from a reference."""
    names = [name for name, value in reference.items() if value and np.isfinite(value)]
    marks: list[Intervals | Level] = [Level(origin, "noise", 0.0)]
    said = []
    for index, (trial, quantities) in enumerate(estimates):
        colour, shape = series(index)
        offset = (index - (len(estimates) - 1) / 2) * 0.6 / max(len(estimates), 2)
        differences = [100 * (number(quantities[name]["value"]) / reference[name] - 1) for name in names]
        marks.append(
            Intervals(
                trial,
                colour,
                [place + offset for place in range(len(names))],
                differences,
                [100 * CONFIDENCE * number(quantities[name]["std"]) / abs(reference[name]) for name in names],
                [False] * len(names),
                [with_std(quantities[name]["value"], quantities[name]["std"]) for name in names],
                shape,
            )
        )
        said.append(
            f"{trial}: " + ", ".join(f"{short_name(n)} {d:+.2g} %" for n, d in zip(names, differences, strict=True))
        )
    ticks = [(float(place), short_name(name)) for place, name in enumerate(names)]
    height = 60.0 + max(34.0, 13.0 * len(estimates)) * len(names)
    panel = Panel(Axis(label), Axis(ticks=ticks), marks, height=height)
    return replace(figure, alternative=f"{figure.title}. {'; '.join(said)}.", panels=[panel])
