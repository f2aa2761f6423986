"""A report as text for people at a terminal."""

import math
from collections.abc import Iterator

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from cdp_ident.identification.identifiability import CONFIDENCE
from cdp_ident.model.parameters import CONSTANTS, GROUPS
from cdp_ident.report.contents import Section

_STAGES = {"nominal": "nominal values", "search": "after the search", "refined": "refined"}


def print_report(console: Console, report: Section) -> None:
    """Print the tables and sentences of a report."""
    for part in _parts(report):
        console.print(part)
        console.print()


def summary(report: Section) -> str:
    """Return a fit in one sentence."""
    fitted = [trial["name"] for trial in report["trials"] if trial["role"] == "fit"]
    return f"{', '.join(fitted)}: {report['verdict']}"


def _parts(report: Section) -> Iterator[RenderableType]:
    yield _trials(report)
    yield _physical(report)
    yield _groups(report)
    yield _errors(report)
    if report["effects"]:
        yield _effects(report["effects"])
    yield _sentences("What the trials determine", report["identifiability"]["words"])
    if report["repeatability"]:
        yield _repeatability(report["repeatability"], report["before"]["groups"])
    warnings = [warning["message"] for warning in report["warnings"]]
    if warnings:
        yield _sentences("Warnings", warnings)
    yield Text(report["verdict"], style="bold")


def _trials(report: Section) -> Table:
    table = _table("Trials", "bag", "role", "samples", "free swing [s]", "what was cut or noticed")
    for trial in report["trials"]:
        end = trial["start_s"] + trial["duration_s"]
        swing = f"{trial['start_s']:.2f} to {end:.2f}"
        notes = Text("; ".join(trial["warnings"]))
        table.add_row(Text(trial["bag"]), trial["role"], str(trial["samples"]), swing, notes)
    return table


def _physical(report: Section) -> Table:
    table = _table("Parameters", "parameter", "nominal", "fitted ± std", "unit", "determined by the trials")
    options = report["run"]["options"]
    constants = [constant.symbol for constant in CONSTANTS]
    for symbol, quantity in report["after"]["physical"].items():
        known = options.get(f"known.{symbol}")
        nominal = options[symbol] if symbol in constants else options[f"nominal.{symbol}"] if known is None else known
        if quantity["std"] == 0.0:
            sure = "given"
        elif known is not None:
            sure = "measured"
        else:
            sure = "yes" if quantity["determined"] else "no: nearest to nominal"
        table.add_row(symbol, f"{nominal:.4g}", with_std(quantity["value"], quantity["std"]), quantity["unit"], sure)
    return table


def _groups(report: Section) -> Table:
    table = _table("Groups, all that a free swing depends on", "group", "fitted ± std", "95 % interval", "unit", "is")
    formulas = {group.symbol: group.formula for group in GROUPS}
    for symbol, quantity in report["after"]["groups"].items():
        sure = "determined" if quantity["determined"] else "not determined by these trials"
        value, std, unit = quantity["value"], quantity["std"], quantity["unit"]
        table.add_row(formulas[symbol], with_std(value, std), _interval(value, std), "" if unit == "1" else unit, sure)
    return table


def _errors(report: Section) -> Table:
    window = report["before"]["error"]["fit"]["window_s"]
    title = f"Error, measured against simulated, over windows of {window:.3g} s"
    table = _table(title, "", "fit [mrad]", "held out [mrad]", "Eq. (10), held out [rad²]")
    stages = [(label, report["stages"][stage]) for stage, label in _STAGES.items()]
    if report["effects"]:
        stages.append(("with the effects below", report["after"]["error"]))
    for label, errors in stages:
        table.add_row(
            label,
            _milliradians(errors["fit"]["rmse_rad"]),
            _milliradians(errors["holdout"]["rmse_rad"]),
            f"{_number(errors['holdout']['sse_free_run']):.4g}",
        )
    noise = report["noise_rad"]
    table.add_row("the encoders' noise", f"{_milliradians(noise['theta1'])} and {_milliradians(noise['theta2'])}")
    return table


def _effects(effects: list[Section]) -> Table:
    table = _table(
        "Effects that the paper's model lacks", "effect", "joint", "parameter", "fitted ± std", "unit",
        "held out, without it [mrad]", "also possible",
    )  # fmt: skip
    for effect in effects:
        without = _milliradians(effect["evidence"]["rmse_holdout_before_rad"])
        first = (effect["name"], effect["joint"])
        for name, quantity in effect["parameters"].items():
            value = with_std(quantity["value"], quantity["std"])
            last = (without, ", ".join(effect["also_possible"])) if first[0] else ("", "")
            table.add_row(*first, name, value, "" if quantity["unit"] == "1" else quantity["unit"], *last)
            first = ("", "")
    return table


def _repeatability(repeatability: Section, joint: Section) -> Table:
    verdict = "agree" if repeatability["agree"] else "do not agree"
    title = f"Each trial alone: they {verdict} (p = {repeatability['p_value']:.2g})"
    formulas = {group.symbol: group.formula for group in GROUPS}
    table = _table(title, "group", "jointly", *(trial["trial"] for trial in repeatability["trials"]))
    for symbol, quantity in joint.items():
        alone = [trial["groups"][symbol] for trial in repeatability["trials"]]
        table.add_row(
            formulas[symbol], *(with_std(estimate["value"], estimate["std"]) for estimate in (quantity, *alone))
        )
    return table


def _table(title: str, *columns: str) -> Table:
    table = Table(title=Text(title, style="bold"), title_justify="left", box=None, pad_edge=False, padding=(0, 3, 0, 0))
    for column in columns:
        table.add_column(Text(column), overflow="fold")
    return table


def _sentences(title: str, sentences: list[str]) -> Group:
    lines = [Padding(Text(f"- {sentence}"), (0, 0, 0, 2)) for sentence in sentences]
    return Group(Text(title, style="bold"), *lines)


def with_std(value: float | None, std: float | None) -> str:
    """Write a value with its standard deviation, both to the latter's two leading digits."""
    number, deviation = _number(value), _number(std)
    if deviation == 0.0:
        return f"{number:.6g}"
    return f"{_to_digits_of(deviation, number)} ± {_to_digits_of(deviation, deviation)}"


def _interval(value: float | None, std: float | None) -> str:
    number, deviation = _number(value), _number(std)
    low, high = number - CONFIDENCE * deviation, number + CONFIDENCE * deviation
    return f"{_to_digits_of(deviation, low)} to {_to_digits_of(deviation, high)}"


def _to_digits_of(deviation: float, number: float) -> str:
    """Write a number as precisely as two digits of its standard deviation allow."""
    if not (math.isfinite(number) and math.isfinite(deviation) and 1e-10 < deviation < 1e6):
        return f"{number:.5g}"
    return f"{number:.{max(0, 1 - math.floor(math.log10(deviation)))}f}"


def _milliradians(radians: float | None) -> str:
    return f"{1e3 * _number(radians):.4g}"


def _number(value: float | None) -> float:
    """Return a number of the report, in which null stands for what is not finite."""
    return math.inf if value is None else float(value)
