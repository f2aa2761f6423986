# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draws reports for people: page, text and figures, from `report.json` and `curves.npz` alone."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

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


def draw(folder: Path, for_paper: bool = False) -> None:
    """Draw the report in a folder: page and text; only `for_paper` the figures as files, to which the text links then.

    Page and figures that were drawn there before go.

    Raises:
        ReportError: there is no complete report in it.
        OptionError: it cannot be written to.
    """
    report = read_report(folder / REPORT)
    curves = read_curves(folder / CURVES, len(report["trials"]), len(report["effects"]))
    document = document_of(report, curves)
    _draw(folder, document, (PAGE, TEXT), for_paper, drawn_with(folder), True, report, curves)


def draw_comparison(folder: Path, document: Document, force: bool) -> None:
    """Draw a comparison into a folder: page, text and figures.

    Raises:
        OptionError: the folder cannot be written, or has such files without `force`.
    """
    _draw(folder, document, (COMPARISON_PAGE, COMPARISON_TEXT), True, (), force)


def _draw(
    folder: Path,
    document: Document,
    names: tuple[str, str],
    for_paper: bool,
    before: Iterable[str],
    force: bool,
    *of_report: Any,
) -> None:
    # Only who draws waits for what draws to be loaded.
    from cdp_ident.report.page import page_of  # noqa: PLC0415

    page, text = names
    files: dict[str, str | bytes] = {page: page_of(document, *of_report), text: markdown(document, for_paper)}
    if for_paper:
        from cdp_ident.report.figures.for_paper import png_and_svg  # noqa: PLC0415

        for figure in document.figures:
            files[f"{FIGURES}/{figure.name}.png"], files[f"{FIGURES}/{figure.name}.svg"] = png_and_svg(figure)
    write_files(folder, files, (page, *before), force)
