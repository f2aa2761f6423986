# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A document, of what it is made, and as text: at a terminal and as Markdown; `pictures` has it as a page.

Each table, sentence and figure stands once, for all forms.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup
from rich.console import Console
from rich.padding import Padding
from rich.table import Table as PrintedTable
from rich.text import Text

from cdp_ident.report.figures.description import Figure
from cdp_ident.report.folder import FIGURES
from cdp_ident.report.wording import capitalised

_SPECIAL = re.compile(r"([\\`*_\[\]#|~])")
"""Letters that mean something in Markdown."""

Row = tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A table; without rows it is left out."""

    title: str
    columns: Row
    rows: Sequence[Row]
    """The first cell of each says what it is about."""
    note: str = ""
    folded: bool = False
    """Whether a page opens it only when it is asked for."""
    at_terminal: bool = True
    wide: Row = ()
    """Columns that a terminal has no room for."""

    @classmethod
    def of(cls, title: str, things: Iterable[Any], columns: Mapping[str, Callable[[Any], str]], **more: Any) -> "Table":
        """Return a table with a row for each thing, given what each column says of one."""
        return cls(title, tuple(columns), [tuple(says(thing) for says in columns.values()) for thing in things], **more)


@dataclass(frozen=True)
class Sentences:
    """A list of sentences; a single one without a title is a paragraph, and none is left out."""

    rows: Sequence[str]
    title: str = ""
    noted: bool = False
    """Whether they stand out."""

    @classmethod
    def of(cls, phrases: Iterable[str], title: str = "", noted: bool = False) -> "Sentences":
        """Write phrases as sentences; a symbol at the beginning of one, such as m1 or g, is not capitalised."""
        rows = []
        for phrase in phrases:
            first = phrase.partition(" ")[0]
            begun = capitalised(phrase) if first.isalpha() and len(first) > 1 else phrase
            rows.append(begun if begun.endswith(".") else f"{begun}.")
        return cls(rows, title, noted)

    @property
    def listed(self) -> bool:
        """Whether they are a list."""
        return bool(self.title) or len(self.rows) > 1


@dataclass(frozen=True)
class Charts:
    """Figures; without any they are left out."""

    figures: Sequence[Figure]
    side_by_side: bool = False
    """Where a window is wide enough."""


Parts = Sequence[Table | Sentences | Charts]


@dataclass(frozen=True)
class Chapter:
    """Parts under one title."""

    key: str
    title: str
    parts: Parts

    @property
    def shown(self) -> Parts:
        """The parts that are not empty."""
        return [part for part in self.parts if (part.figures if isinstance(part, Charts) else part.rows)]


@dataclass(frozen=True)
class Document:
    """Chapters under a heading."""

    about: str
    """What kind of a document it is."""
    heading: str
    verdict: str
    """All of it in one sentence."""
    chapters: Sequence[Chapter]

    @property
    def figures(self) -> list[Figure]:
        """Its figures, in their order."""
        parts = (part for chapter in self.chapters for part in chapter.parts)
        return [figure for part in parts if isinstance(part, Charts) for figure in part.figures]


class Code(str):
    """A sentence that is a line to be typed."""

    __slots__ = ()

    def __html__(self) -> Markup:
        """Return it as HTML."""
        return Markup("<code>{}</code>").format(str(self))


def markdown(document: Document, with_figures: bool) -> str:
    """Return a document as Markdown; nothing in its texts is taken for Markdown or HTML."""
    blocks = [f"# {_literal(document.heading)}", _literal(document.verdict)]
    for chapter in document.chapters:
        inside = list(_blocks(chapter, with_figures))
        if inside and chapter.title:
            blocks.append(f"## {_literal(chapter.title)}")
        blocks += inside
    return "\n\n".join(filter(None, blocks)) + "\n"


def _blocks(chapter: Chapter, with_figures: bool) -> Iterator[str]:
    for part in chapter.shown:
        if isinstance(part, Table | Sentences):
            yield f"**{_literal(part.title)}**" if part.title else ""
        if isinstance(part, Table):
            rows = ([_literal(cell) for cell in row] for row in (part.columns, *part.rows))
            heading, *others = (f"| {' | '.join(row)} |" for row in rows)
            yield "\n".join([heading, f"|{' --- |' * len(part.columns)}", *others])
            yield _literal(part.note)
        elif isinstance(part, Sentences):
            bullet = "- " if part.listed else ""
            yield "\n".join(f"{bullet}{_literal(said)}" for said in part.rows)
        elif with_figures:
            for figure in part.figures:
                yield f"**{_literal(figure.title)}.** {_literal(figure.caption)}"
                yield f"![{_literal(figure.alternative)}]({FIGURES}/{figure.name}.svg)"


def _literal(text: str) -> str:
    if isinstance(text, Code):
        return "`{}`".format(" ".join(text.split()).replace("`", "'"))
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()).replace("&", "&amp;").replace("<", "&lt;"))


def wide_console(width: int = 140, stderr: bool = False) -> Console:
    """Return the terminal; where there is none, what is so wide: as tables of several runs or rigs."""
    console = Console(highlight=False, markup=False, stderr=stderr)
    return console if console.is_terminal else Console(highlight=False, markup=False, stderr=stderr, width=width)


def print_document(console: Console, document: Document) -> None:
    """Print the tables and sentences of a document; the result comes last, where people look."""
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
            print_table(console, part)
            if part.note:
                console.print(part.note)
        else:
            for said in part.rows:
                console.print(Padding(Text(f"- {said}"), (0, 0, 0, 2)) if part.listed else Text(said))
        console.print()


def print_table(console: Console, part: Table) -> None:
    """Print the columns and rows of a table."""
    table = PrintedTable(box=None, pad_edge=False, padding=(0, 3, 0, 0), show_header=any(part.columns))
    shown = [place for place, column in enumerate(part.columns) if column not in part.wide]
    for place in shown:
        table.add_column(Text(part.columns[place]), overflow="fold")
    for row in part.rows:
        table.add_row(*(Text(row[place]) for place in shown))
    console.print(table)
