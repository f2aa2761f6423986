"""A document as text for people at a terminal."""

from rich.console import Console
from rich.padding import Padding
from rich.table import Table as Drawn
from rich.text import Text

from cdp_ident.report.chapters import document_of
from cdp_ident.report.parts import Chapter, Charts, Table
from cdp_ident.report.schema import Section


def wide_console() -> Console:
    """Return the terminal; where there is none, what is as wide as tables of several runs or rigs."""
    console = Console(highlight=False, markup=False)
    return console if console.is_terminal else Console(highlight=False, markup=False, width=140)


def print_report(console: Console, report: Section) -> None:
    """Print the tables and sentences of a report; the result comes last, where people look."""
    document = document_of(report)
    result, *others = document.chapters
    for chapter in (*others, result):
        print_chapter(console, chapter)
    console.print(Text(document.verdict, style="bold"))
    console.print()


def print_chapter(console: Console, chapter: Chapter) -> None:
    """Print the tables and sentences of a chapter."""
    heading = chapter.title
    for part in chapter.shown:
        if isinstance(part, Charts) or (isinstance(part, Table) and not part.at_terminal):
            continue
        for title in filter(None, (heading, part.title)):
            console.print(Text(title, style="bold underline" if title is heading else "bold"))
        heading = ""
        if isinstance(part, Table):
            console.print(_drawn(part))
            if part.note:
                console.print(part.note)
        else:
            for said in part.rows:
                console.print(Padding(Text(f"- {said}"), (0, 0, 0, 2)) if part.listed else Text(said))
        console.print()


def summary(report: Section) -> str:
    """Return a fit in one sentence."""
    fitted = [trial["name"] for trial in report["trials"] if trial["role"] == "fit"]
    return f"{', '.join(fitted)}: {report['verdict']}"


def _drawn(part: Table) -> Drawn:
    table = Drawn(box=None, pad_edge=False, padding=(0, 3, 0, 0), show_header=any(part.columns))
    shown = [place for place, column in enumerate(part.columns) if column not in part.wide]
    for place in shown:
        table.add_column(Text(part.columns[place]), overflow="fold")
    for row in part.rows:
        table.add_row(*(Text(row[place]) for place in shown))
    return table
