"""Draws reports for people: page, text and figures, from `report.json` and `curves.npz` alone."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from cdp_ident.errors import ReportError
from cdp_ident.report.chapters import document_of
from cdp_ident.report.curves_file import read_curves
from cdp_ident.report.document import Document, markdown
from cdp_ident.report.folder import (
    COMPARISON_PAGE,
    COMPARISON_TEXT,
    CURVES,
    FIGURES,
    PAGE,
    REPORT,
    TEXT,
    drawn_with,
    write_files,
)
from cdp_ident.report.report_file import read_report


class Drawn(NamedTuple):
    """What was drawn."""

    files: dict[str, str | bytes]
    """Page, text and figures by their names in a folder."""
    problem: str = ""
    """Why there is no page, where there is none: the library that draws it may be missing."""


def draw(folder: Path, for_paper: bool = False) -> str:
    """Draw the report in a folder: page and text; only `for_paper` the figures as files, to which the text links then.

    Page and figures that were drawn there before go. Returns why there is no page, where there is none.

    Raises:
        ReportError: there is no complete report in it.
        OptionError: it cannot be written to.
    """
    # Only who draws waits for what draws to be loaded.
    from cdp_ident.report.page import report_html  # noqa: PLC0415

    report = read_report(folder / REPORT)
    curves = read_curves(folder / CURVES, len(report["trials"]), len(report["effects"]))
    document = document_of(report, curves)
    drawn = _drawn(TEXT, document, for_paper, PAGE, lambda: report_html(report, curves, document))
    write_files(folder, drawn.files, instead_of=(PAGE, *drawn_with(folder)))
    return drawn.problem


def draw_comparison(document: Document) -> Drawn:
    """Draw a comparison: page, text and figures."""
    from cdp_ident.report.page import render_page  # noqa: PLC0415

    return _drawn(COMPARISON_TEXT, document, True, COMPARISON_PAGE, lambda: render_page(document))


def _drawn(text: str, document: Document, for_paper: bool, name: str, page: Callable[[], str]) -> Drawn:
    files: dict[str, str | bytes] = {text: markdown(document, for_paper)}
    if for_paper:
        from cdp_ident.report.figures.for_paper import png_and_svg  # noqa: PLC0415

        for figure in document.figures:
            files[f"{FIGURES}/{figure.name}.png"], files[f"{FIGURES}/{figure.name}.svg"] = png_and_svg(figure)
    try:
        return Drawn({name: page(), **files})
    except ReportError as error:
        return Drawn(files, str(error))
