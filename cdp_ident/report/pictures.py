# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draws reports for people: page, text and figures, from `report.json` and `curves.npz` alone."""

from pathlib import Path

from cdp_ident.report.chapters import document_of
from cdp_ident.report.curves import Curves, read_curves
from cdp_ident.report.document import Document, markdown
from cdp_ident.report.folder import CURVES, FIGURES, PAGE, REPORT, TEXT, drawn_with, write_files
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section


def draw(folder: Path, for_paper: bool = False) -> None:
    """Draw the report in a folder: page and text; only `for_paper` the figures as files, to which the text links then.

    Page and figures that were drawn there before go.

    Raises:
        ReportError: there is no complete report in it.
        OptionError: it cannot be written to.
    """
    report = read_report(folder / REPORT)
    curves = read_curves(folder / CURVES, len(report["trials"]), len(report["effects"]))
    files = files_of(document_of(report, curves), PAGE, TEXT, for_paper, report, curves)
    write_files(folder, files, (PAGE, *drawn_with(folder)))


def files_of(
    document: Document,
    page: str,
    text: str,
    for_paper: bool,
    report: Section | None = None,
    curves: Curves | None = None,
) -> dict[str, str | bytes]:
    """Return the files of a document by their names: its page, its text and, only `for_paper`, its figures.

    The page of a `report` has what moves, too.
    """
    # Only who draws waits for what draws to be loaded.
    from cdp_ident.report.page import page_of  # noqa: PLC0415

    files: dict[str, str | bytes] = {page: page_of(document, report, curves), text: markdown(document, for_paper)}
    if for_paper:
        from cdp_ident.report.figures.for_paper import png_and_svg  # noqa: PLC0415

        for figure in document.figures:
            files[f"{FIGURES}/{figure.name}.png"], files[f"{FIGURES}/{figure.name}.svg"] = png_and_svg(figure)
    return files
