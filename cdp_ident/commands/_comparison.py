# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A comparison on the terminal and in a folder."""

from collections.abc import Sequence
from pathlib import Path

from cdp_ident.output_folder import write_files
from cdp_ident.outside_text import shown
from cdp_ident.report.document import Chapter, Charts, Document, Table, print_chapter, wide_console
from cdp_ident.report.figures.description import Figure
from cdp_ident.report.folder import COMPARISON_PAGE, COMPARISON_TEXT, FIGURES
from cdp_ident.report.pictures import files_of


def show_comparison(
    heading: str, tables: Sequence[Table], figures: Sequence[Figure], out: Path | None, force: bool
) -> None:
    """Print tables and, where a folder is given, write page, text and figures into it.

    Raises OptionError where the folder cannot be written, or has such files without `force`.
    """
    console = wide_console()
    first, *others = tables
    chapter = Chapter("result", "", (first, Charts(figures), *others))
    print_chapter(console, chapter)
    if out:
        document = Document("Cart double pendulum, compared", heading, "", (chapter,))
        files, place = files_of(document, COMPARISON_PAGE, COMPARISON_TEXT, for_paper=True), shown(out)
        write_files(out, files, force=force)
        console.print(f"{place}/{COMPARISON_PAGE} is written", soft_wrap=True)
        console.print(f"{place}/{COMPARISON_TEXT} and {FIGURES}/ are written", soft_wrap=True)
