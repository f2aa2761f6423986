"""A report as text for people at a terminal."""

from collections.abc import Iterable, Iterator

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from cdp_ident.model.parameters import GROUPS
from cdp_ident.report.comparison import Comparison
from cdp_ident.report.formatting import interval, milliradians, number, unit, with_std
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import (
    STAGES,
    advice_words,
    candidate_rows,
    determined_words,
    effects_in_words,
    expected_in_words,
    how_determined,
    nominal_value,
    others_words,
    share_words,
    sure_words,
    validation_words,
    weights_words,
)


def print_report(console: Console, report: Section) -> None:
    """Print the tables and sentences of a report."""
    for part in _parts(report):
        console.print(part)
        console.print()


def print_tables(console: Console, tables: Iterable[Comparison]) -> None:
    """Print tables of several reports."""
    for comparison in tables:
        table = _table(comparison.title, *comparison.columns)
        for row in comparison.rows:
            table.add_row(*(Text(cell) for cell in row))
        console.print(table)
        if comparison.note:
            console.print(comparison.note)
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
    yield _sentences("Validation", validation_words(report))
    if report["effects"]:
        yield _effects(report["effects"])
    if candidates := candidate_rows(report):
        yield _candidates(candidates)
    if share := share_words(report):
        yield _sentences("Where effects were looked for", share)
    if expected := expected_in_words(report):
        yield _sentences("Beside the earlier report", expected)
    yield _sentences("What the trials determine", determined_words(report))
    if report["repeatability"]:
        yield _repeatability(report["repeatability"], report["after"]["groups"])
    if report["next_trial"]:
        yield _sentences("Which swing next (angles from hanging, positive towards +x)", advice_words(report))
    warnings = [warning["message"] for warning in report["warnings"]]
    if warnings:
        yield _sentences("Warnings", warnings)
    yield Text(report["verdict"], style="bold")
    if effects := effects_in_words(report):
        yield _sentences("The effects, the most important first", effects)
    if report["unexplained"]["significant"]:
        yield Text(f"What remains: {report['unexplained']['description']}")


def _trials(report: Section) -> Table:
    table = _table("Trials", "bag", "role", "samples", "free swing [s]", "what was cut or noticed")
    for trial in report["trials"]:
        end = trial["start_s"] + trial["duration_s"]
        swing = f"{trial['start_s']:.2f} to {end:.2f}"
        notes = Text("; ".join(filter(None, (weights_words(trial), *trial["warnings"]))))
        table.add_row(Text(trial["bag"]), trial["role"], str(trial["samples"]), swing, notes)
    return table


def _physical(report: Section) -> Table:
    table = _table("Parameters", "parameter", "nominal", "fitted ± std", "unit", "determined by the trials")
    for symbol, quantity in report["after"]["physical"].items():
        table.add_row(
            symbol,
            f"{nominal_value(report, symbol):.4g}",
            with_std(quantity["value"], quantity["std"]),
            quantity["unit"],
            how_determined(report, symbol),
        )
    return table


def _groups(report: Section) -> Table:
    table = _table(
        "Base parameters, all that a free swing depends on",
        "base parameter",
        "fitted ± std",
        "95 % interval",
        "unit",
        "is",
    )
    formulas = {group.symbol: group.formula for group in GROUPS}
    for symbol, quantity in report["after"]["groups"].items():
        sure = "determined" if quantity["determined"] else "not determined by these trials"
        value, std = quantity["value"], quantity["std"]
        table.add_row(formulas[symbol], with_std(value, std), interval(value, std), unit(quantity["unit"]), sure)
    return table


def _errors(report: Section) -> Table:
    window = report["before"]["error"]["fit"]["window_s"]
    title = f"Error, measured against simulated, over windows of {window:.3g} s"
    table = _table(title, "", "fit [mrad]", "held out [mrad]", "Eq. (10), held out [rad²]")
    stages = [(label, report["stages"][stage]) for stage, label in STAGES.items()]
    if report["effects"]:
        stages.append(("with the effects below", report["after"]["error"]))
    for label, errors in stages:
        table.add_row(
            label,
            *(milliradians(errors[role]["rmse_rad"]) for role in ("fit", "holdout")),
            f"{number(errors['holdout']['sse_free_run']):.4g}",
        )
    noise = report["noise_rad"]
    table.add_row("the encoders' noise", f"{milliradians(noise['theta1'])} and {milliradians(noise['theta2'])}")
    return table


def _effects(effects: list[Section]) -> Table:
    table = _table(
        "Effects that the paper's model lacks", "effect", "joint", "parameter", "fitted ± std", "unit",
        "how sure", "held out, without it [mrad]", "also possible",
    )  # fmt: skip
    for effect in effects:
        without = milliradians(effect["evidence"]["rmse_holdout_before_rad"])
        first = (effect["name"], effect["joint"])
        for name, quantity in effect["parameters"].items():
            value = with_std(quantity["value"], quantity["std"])
            last = (sure_words(effect), without, others_words(effect)) if first[0] else ("", "", "")
            table.add_row(*first, name, value, unit(quantity["unit"]), *last)
            first = ("", "")
    return table


def _candidates(rows: list[tuple[str, str, str]]) -> Table:
    table = _table("What else was looked for", "effect", "odds, were it added", "probability")
    for row in rows:
        table.add_row(*row)
    return table


def _repeatability(repeatability: Section, joint: Section) -> Table:
    verdict = "agree" if repeatability["agree"] else "do not agree"
    title = f"Each trial alone: they {verdict} (p = {repeatability['p_value']:.2g})"
    formulas = {group.symbol: group.formula for group in GROUPS}
    table = _table(title, "base parameter", "jointly", *(trial["trial"] for trial in repeatability["trials"]))
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
