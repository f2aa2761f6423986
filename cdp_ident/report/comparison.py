# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Several reports side by side, as before and after a bearing was changed."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from cdp_ident.errors import OptionError
from cdp_ident.model.parameters import GROUPS
from cdp_ident.report.document import Row, Table
from cdp_ident.report.folder import REPORT
from cdp_ident.report.parameters import how_determined
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import effect_name, group_words, in_unit, milliradians, noise_floor, quantity_words

CHANGED = 3.0
"""A difference of so many of its standard deviations is called a change."""
_NONE = "–"


@dataclass(frozen=True)
class Quantity:
    """A number of a report, to be read and to be compared."""

    text: str
    value: float = math.nan
    """As the motion shows it; not a number where it says nothing."""
    std: float = math.nan

    @property
    def is_known(self) -> bool:
        """Whether it can be compared."""
        return math.isfinite(self.value) and math.isfinite(self.std) and self.std > 0.0


def fitted_quantity(report: Section, kind: str, name: str) -> Quantity:
    """Return one of the `groups` or of the `physical` values of the model that a report ends with."""
    found = report["after"][kind][name]
    text = in_unit(found["value"], found["std"], found["unit"])
    # A physical value that is not determined is where the nominal values have put it, and one that was measured
    # beforehand where that has: in all reports alike.
    says_something = kind == "groups" or how_determined(report, name) == "yes"
    return Quantity(text, found["value"], found["std"]) if says_something else Quantity(text)


def effect_quantities(report: Section, of_trials: bool = True) -> dict[str, Quantity]:
    """Return the parameters of the effects by what people call them; their values are of torques over A22.

    `of_trials` says whether effects are among them that belong to one trial alone.
    """
    found = {}
    for effect in report["effects"]:
        if effect["trial"] and not of_trials:
            continue
        for name, quantity in effect["parameters"].items():
            shown = [quantity["as_fitted"][of] for of in ("value", "std")]
            found[f"{effect_name(effect)}: {name}"] = Quantity(quantity_words(quantity), *shown)
    return found


def read_runs(folders: Sequence[Path]) -> dict[str, Section]:
    """Read the reports of several folders, by the shortest ends of the paths that differ.

    Raises:
        OptionError: there are fewer than two, or one is given twice.
        ReportError: one of them holds no report.
    """
    if len(folders) < 2:
        raise OptionError("there is nothing to compare: give at least two folders that identify wrote into")
    paths = [folder.resolve().parts for folder in folders]
    for index, (folder, path) in enumerate(zip(folders, paths, strict=True)):
        if path in paths[:index]:
            raise OptionError(f"{folder} is given twice: give each folder once")
    length = 1
    while len({path[-length:] for path in paths}) < len(paths):
        length += 1
    return {"/".join(path[-length:]): read_report(folder / REPORT) for path, folder in zip(paths, folders, strict=True)}


def compare(runs: Mapping[str, Section]) -> list[Table]:
    """Return what to put side by side of reports, by name: verdicts, errors, parameters and effects."""
    names, reports = tuple(runs), list(runs.values())
    columns = (*names, *(f"{name} − {names[0]}, in std" for name in names[1:]))
    effects = [effect_quantities(report) for report in reports]

    def row(name: str, kind: str, symbol: str) -> Row:
        return _row(name, [fitted_quantity(report, kind, symbol) for report in reports])

    differences = "A difference is in standard deviations of itself"
    return [
        Table("Verdicts", ("run", "verdict"), [(name, report["verdict"]) for name, report in runs.items()]),
        Table("Errors", ("", *names), list(_errors(reports))),
        Table(
            "Base parameters, all that a free swing depends on",
            ("base parameter", *columns),
            [row(group_words(group), "groups", group.symbol) for group in GROUPS],
            f"{differences}; from {CHANGED:.0f} on it is marked as changed.",
        ),
        Table(
            "Effects",
            ("effect", *columns),
            [_row(name, [of.get(name, Quantity(_NONE)) for of in effects]) for name in dict.fromkeys(chain(*effects))],
            f"{differences}, of torques over A22, which is all that a free swing shows of them.",
        ),
        Table(
            "Physical values",
            ("parameter", *columns),
            [row(symbol, "physical", symbol) for symbol in reports[0]["after"]["physical"]],
            "Values that the trials do not determine lie nearest to the nominal ones: their differences say nothing.",
        ),
    ]


def _row(name: str, quantities: Sequence[Quantity]) -> Row:
    first, *others = quantities
    return (name, *(quantity.text for quantity in quantities), *(_difference(first, other) for other in others))


def _difference(first: Quantity, other: Quantity) -> str:
    std = math.hypot(first.std, other.std)
    if not (math.isfinite(std) and std > 0):
        return _NONE
    distance = (other.value - first.value) / std
    return f"{distance:+.1f}{' (changed)' if abs(distance) >= CHANGED else ''}"


def _errors(reports: Sequence[Section]) -> Iterator[Row]:
    for model, words in (("before", "the paper's model, fitted"), ("after", "with the effects found")):
        for where, said in (("holdout", "held out"), ("fit", "fitted motion")):
            errors = [report[model]["error"][where]["rmse_rad"] for report in reports]
            yield f"{words}, {said} [mrad]", *(milliradians(error) for error in errors)
    yield "the encoders' noise [mrad]", *(milliradians(noise_floor(report)) for report in reports)
    squared = [report["after"]["error"]["holdout"]["sse_free_run"] for report in reports]
    yield "with the effects found, Eq. (10), held out [rad²]", *(f"{error:.4g}" for error in squared)
