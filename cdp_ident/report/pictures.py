"""Draws a report for people: page, text and figures, from `report.json` and `curves.npz` alone."""

from collections.abc import Mapping
from pathlib import Path

from cdp_ident.report.contents import Section
from cdp_ident.report.curves import Curves
from cdp_ident.report.curves_file import read_curves
from cdp_ident.report.figures.all import figures
from cdp_ident.report.folder import CURVES, FIGURES, PAGE, REPORT, TEXT, write_files
from cdp_ident.report.report_file import read_report


def draw(report: Section, curves: Curves) -> dict[str, str | bytes]:
    """Return page, text and figures of a report by their names in its folder.

    Raises:
        ReportError: a library that draws is not installed.
    """
    # Only who draws waits for what draws to be loaded.
    from cdp_ident.report.figures.for_paper import png_and_svg  # noqa: PLC0415
    from cdp_ident.report.page.report_page import report_html, report_md  # noqa: PLC0415

    shown = figures(report, curves)
    files: dict[str, str | bytes] = {PAGE: report_html(report, curves, shown), TEXT: report_md(report, shown, FIGURES)}
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
        if path.suffix in (".png", ".svg") and f"{FIGURES}/{path.name}" not in files:
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
