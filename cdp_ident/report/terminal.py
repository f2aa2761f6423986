"""A report as text for people at a terminal."""

from collections.abc import Iterable, Iterator, Sequence

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from cdp_ident.report.comparison import Comparison
from cdp_ident.report.formatting import milliradians, number
from cdp_ident.report.page.words import words
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import STAGES


def print_report(console: Console, report: Section) -> None:
    """Print the tables and sentences of a report."""
    for part in _parts(report):
        console.print(part)
        console.print()


def print_tables(console: Console, tables: Iterable[Comparison]) -> None:
    """Print tables of several reports."""
    for comparison in tables:
        console.print(_table(comparison.title, comparison.columns, comparison.rows))
        if comparison.note:
            console.print(comparison.note)
        console.print()


def summary(report: Section) -> str:
    """Return a fit in one sentence."""
    fitted = [trial["name"] for trial in report["trials"] if trial["role"] == "fit"]
    return f"{', '.join(fitted)}: {report['verdict']}"


def _parts(report: Section) -> Iterator[RenderableType]:
    said = words(report)
    rows = said["rows"]
    trials = ("bag", "role", "samples", "free swing [s]", "weights", "what was cut or noticed")
    yield _table("Trials", trials, rows["trials"])
    physical = [(symbol, nominal, *fitted) for symbol, _, nominal, *fitted in rows["physical"]]
    in_intervals = ("fitted ± std", "95 % interval", "unit")
    yield _table("Parameters", ("parameter", "nominal", *in_intervals, "determined by the trials"), physical)
    groups = [(name, *fitted) for name, _, *fitted in rows["groups"]]
    title = "Base parameters, all that a free swing depends on"
    yield _table(title, ("base parameter", *in_intervals, "determined"), groups)
    yield _errors(report)
    yield _sentences("Validation", said["validation"])
    if rows["effects"]:
        effects = [(*row[:5], row[6]) for row in rows["effects"]]  # without the formula
        columns = ("effect", "parameter", "fitted ± std", "how sure", "held out without → with [mrad]", "also possible")
        yield _table("Effects that the paper's model lacks", columns, effects)
    if rows["candidates"]:
        odds = ("effect", "odds, were it added", "probability")
        yield _table("What else was looked for", odds, rows["candidates"])
    if said["share"]:
        yield _sentences("Where effects were looked for", said["share"])
    if said["expected"]:
        yield _sentences("Beside the earlier report", said["expected"])
    yield _sentences("What the trials determine", said["determined"])
    if rows["repeatability"]:
        compared = report["repeatability"]
        verdict = "agree" if compared["agree"] else "do not agree"
        title = f"Each trial alone: they {verdict} (p = {compared['p_value']:.2g})"
        yield _table(title, rows["repeatability"][0], rows["repeatability"][1:])
    if said["advice"]:
        yield _sentences("Which swing next (angles from hanging, positive towards +x)", said["advice"])
    warnings = [warning["message"] for warning in report["warnings"]]
    if warnings:
        yield _sentences("Warnings", warnings)
    yield Text(report["verdict"], style="bold")
    if said["found"]:
        yield _sentences("The effects, the most important first", said["found"])
    if report["unexplained"]["significant"]:
        yield Text(f"What remains: {report['unexplained']['description']}")


def _errors(report: Section) -> Table:
    window = report["before"]["error"]["fit"]["window_s"]
    title = f"Error, measured against simulated, over windows of {window:.3g} s"
    stages = [(label, report["stages"][stage]) for stage, label in STAGES.items()]
    if report["effects"]:
        stages.append(("with the effects below", report["after"]["error"]))
    rows = [
        (
            label,
            *(milliradians(errors[role]["rmse_rad"]) for role in ("fit", "holdout")),
            f"{number(errors['holdout']['sse_free_run']):.4g}",
        )
        for label, errors in stages
    ]
    noise = " and ".join(map(milliradians, report["noise_rad"].values()))
    columns = ("", "fit [mrad]", "held out [mrad]", "Eq. (10), held out [rad²]")
    return _table(title, columns, [*rows, ("the encoders' noise", noise)])


def _table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    table = Table(title=Text(title, style="bold"), title_justify="left", box=None, pad_edge=False, padding=(0, 3, 0, 0))
    for column in columns:
        table.add_column(Text(column), overflow="fold")
    for row in rows:
        table.add_row(*map(Text, row))
    return table


def _sentences(title: str, sentences: list[str]) -> Group:
    lines = [Padding(Text(f"- {sentence}"), (0, 0, 0, 2)) for sentence in sentences]
    return Group(Text(title, style="bold"), *lines)
