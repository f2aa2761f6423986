"""Draws reports for people: page, text and figures, from `report.json` and `curves.npz` alone."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from cdp_ident.report.comparison import Run
from cdp_ident.report.contents import Section
from cdp_ident.report.curves import Curves
from cdp_ident.report.curves_file import read_curves
from cdp_ident.report.figures.all import figures
from cdp_ident.report.figures.description import Figure
from cdp_ident.report.folder import (
    COMPARISON_PAGE,
    COMPARISON_TEXT,
    CURVES,
    FIGURES,
    PAGE,
    PICTURES,
    REPORT,
    TEXT,
    write_files,
)
from cdp_ident.report.report_file import read_report


def draw(report: Section, curves: Curves) -> dict[str, str | bytes]:
    """Return page, text and figures of a report by their names in its folder.

    Raises:
        ReportError: a library that draws is not installed.
    """
    # Only who draws waits for what draws to be loaded.
    from cdp_ident.report.page.report_page import report_html, report_md  # noqa: PLC0415

    shown = figures(report, curves)
    page, text = report_html(report, curves, shown), report_md(report, shown, FIGURES)
    return {PAGE: page, TEXT: text, **_for_paper(shown)}


def draw_comparison(runs: Sequence[Run]) -> dict[str, str | bytes]:
    """Return page, text and figure of a comparison by their names.

    Raises:
        ReportError: a library that draws is not installed.
    """
    from cdp_ident.report.page.comparison_page import (  # noqa: PLC0415
        comparison_figures,
        comparison_html,
        comparison_md,
    )

    shown = comparison_figures(runs)
    page, text = comparison_html(runs, shown), comparison_md(runs, shown, FIGURES)
    return {COMPARISON_PAGE: page, COMPARISON_TEXT: text, **_for_paper(shown)}


def _for_paper(shown: Sequence[Figure]) -> dict[str, str | bytes]:
    from cdp_ident.report.figures.for_paper import png_and_svg  # noqa: PLC0415

    files: dict[str, str | bytes] = {}
    for figure in shown:
        files[f"{FIGURES}/{figure.name}.png"], files[f"{FIGURES}/{figure.name}.svg"] = png_and_svg(figure)
    return files


def write_pictures(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write what was drawn; figures of an earlier report in the folder go.

    Raises:
        OptionError: the folder or a file cannot be written.
    """
    write_files(folder, files)
    for path in (folder / FIGURES).iterdir():
        if path.suffix in PICTURES and f"{FIGURES}/{path.name}" not in files:
            path.unlink(missing_ok=True)


def draw_again(folder: Path) -> None:
    """Draw the report in a folder anew.

    Raises:
        ReportError: there is no complete report in it.
        OptionError: it cannot be written to.
    """
    report = read_report(folder / REPORT)
    curves = read_curves(folder / CURVES, len(report["trials"]), len(report["effects"]))
    write_pictures(folder, draw(report, curves))
