"""A document as Markdown text, with links to the figures' SVG files in a folder beside it."""

import re
from collections.abc import Iterator

from cdp_ident.report.folder import FIGURES
from cdp_ident.report.parts import Chapter, Code, Document, Row, Sentences, Table

_SPECIAL = re.compile(r"([\\`*_\[\]#|~])")


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
            yield "\n".join(map(_row, (part.columns, ("---",) * len(part.columns), *part.rows)))
            yield _literal(part.note)
        elif isinstance(part, Sentences):
            bullet = "- " if part.listed else ""
            yield "\n".join(f"{bullet}{_literal(said)}" for said in part.rows)
        elif with_figures:
            for figure in part.figures:
                yield f"**{_literal(figure.title)}.** {_literal(figure.caption)}"
                yield f"![{_literal(figure.alternative)}]({FIGURES}/{figure.name}.svg)"


def _row(cells: Row) -> str:
    return f"| {' | '.join(map(_literal, cells))} |"


def _literal(text: str) -> str:
    if isinstance(text, Code):
        return "`{}`".format(" ".join(text.split()).replace("`", "'"))
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()).replace("&", "&amp;").replace("<", "&lt;"))
