"""Several reports side by side, as before and after a bearing was changed."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from cdp_ident.errors import OptionError
from cdp_ident.model.parameters import GROUPS
from cdp_ident.report.document import Table
from cdp_ident.report.folder import REPORT
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import (
    effect_name,
    group_words,
    how_determined,
    in_unit,
    milliradians,
    noise_floor,
    quantity_words,
)

CHANGED = 3.0
"""A difference of so many of its standard deviations is called a change."""
_NONE = "–"


@dataclass(frozen=True)
class Run:
    """One of the reports that are compared."""

    name: str
    report: Section


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


def read_runs(folders: Sequence[Path]) -> list[Run]:
    """Read the reports of several folders; their names are the shortest ends of the paths that differ.

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
    return [
        Run("/".join(path[-length:]), read_report(folder / REPORT)) for path, folder in zip(paths, folders, strict=True)
    ]


def compare(runs: Sequence[Run]) -> list[Table]:
    """Return what to put side by side: verdicts, errors, base parameters, effects and physical values."""
    names = tuple(run.name for run in runs)
    others = tuple(f"{name} − {names[0]}, in std" for name in names[1:])
    groups = [(group_words(g), [fitted_quantity(run.report, "groups", g.symbol) for run in runs]) for g in GROUPS]
    symbols = runs[0].report["after"]["physical"]
    physical = [(symbol, [fitted_quantity(run.report, "physical", symbol) for run in runs]) for symbol in symbols]
    differences = "A difference is in standard deviations of itself"
    return [
        Table("Verdicts", ("run", "verdict"), tuple((run.name, run.report["verdict"]) for run in runs)),
        Table("Errors", ("", *names), tuple(_errors(runs))),
        Table(
            "Base parameters, all that a free swing depends on",
            ("base parameter", *names, *others),
            tuple(_row(name, quantities) for name, quantities in groups),
            f"{differences}; from {CHANGED:.0f} on it is marked as changed.",
        ),
        Table(
            "Effects",
            ("effect", *names, *others),
            tuple(_row(name, quantities) for name, quantities in _effects(runs).items()),
            f"{differences}, of torques over A22, which is all that a free swing shows of them.",
        ),
        Table(
            "Physical values",
            ("parameter", *names, *others),
            tuple(_row(name, quantities) for name, quantities in physical),
            "Values that the trials do not determine lie nearest to the nominal ones: their differences say nothing.",
        ),
    ]


def _effects(runs: Sequence[Run]) -> Mapping[str, list[Quantity]]:
    found: dict[str, list[Quantity]] = {}
    for index, run in enumerate(runs):
        for name, quantity in effect_quantities(run.report).items():
            found.setdefault(name, [Quantity(_NONE)] * len(runs))[index] = quantity
    return found


def _row(name: str, quantities: Sequence[Quantity]) -> tuple[str, ...]:
    first, *others = quantities
    return (name, *(quantity.text for quantity in quantities), *(_difference(first, other) for other in others))


def _difference(first: Quantity, other: Quantity) -> str:
    std = math.hypot(first.std, other.std)
    if not (math.isfinite(std) and std > 0):
        return _NONE
    distance = (other.value - first.value) / std
    return f"{distance:+.1f}{' (changed)' if abs(distance) >= CHANGED else ''}"


def _errors(runs: Sequence[Run]) -> Iterator[tuple[str, ...]]:
    for model, words in (("before", "the paper's model, fitted"), ("after", "with the effects found")):
        for where, said in (("holdout", "held out"), ("fit", "fitted motion")):
            errors = [run.report[model]["error"][where]["rmse_rad"] for run in runs]
            yield f"{words}, {said} [mrad]", *(milliradians(error) for error in errors)
    yield "the encoders' noise [mrad]", *(milliradians(noise_floor(run.report)) for run in runs)
    squared = [run.report["after"]["error"]["holdout"]["sse_free_run"] for run in runs]
    yield "with the effects found, Eq. (10), held out [rad²]", *(f"{error:.4g}" for error in squared)
