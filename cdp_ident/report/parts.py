"""What a document is made of: each table, sentence and figure once, for page, Markdown text and terminal alike."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from cdp_ident.report.figures.description import Figure

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


@dataclass(frozen=True)
class Sentences:
    """A list of sentences; a single one without a title is a paragraph, and none is left out."""

    rows: Sequence[str]
    title: str = ""
    noted: bool = False
    """Whether they stand out."""

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
