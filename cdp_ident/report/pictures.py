"""Draws reports for people: page, text and figures, from `report.json` and `curves.npz` alone."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from cdp_ident.errors import ReportError
from cdp_ident.report.chapters import document_of
from cdp_ident.report.curves import Curves
from cdp_ident.report.curves_file import read_curves
from cdp_ident.report.figures.description import Figure
from cdp_ident.report.figures.errors import before_and_after, best_error, candidates, selection
from cdp_ident.report.figures.motion import angles, continuous_runs
from cdp_ident.report.figures.next_trial import next_trial
from cdp_ident.report.figures.parameters import against_nominal, correlation, repeatability
from cdp_ident.report.figures.torques import effects_through_residuals, missing_torques, nonparametric_torques
from cdp_ident.report.figures.validation import prediction, residual_correlation
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
from cdp_ident.report.markdown import markdown
from cdp_ident.report.parts import Document
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section


class Drawn(NamedTuple):
    """What was drawn."""

    files: dict[str, str | bytes]
    """Page, text and figures by their names in a folder."""
    problem: str = ""
    """Why there is no page, where there is none: the library that draws it may be missing."""


def figures(report: Section, curves: Curves) -> list[Figure]:
    """Return the pictures of a report, in the order in which it shows them."""
    return [
        before_and_after(report),
        *angles(report, curves),
        *prediction(report),
        residual_correlation(report),
        *best_error(report),
        *continuous_runs(report, curves),
        *selection(report),
        *candidates(report),
        *missing_torques(report, curves),
        *effects_through_residuals(report, curves),
        *nonparametric_torques(report),
        against_nominal(report),
        *correlation(report),
        *repeatability(report),
        *next_trial(report),
    ]


def draw(report: Section, curves: Curves, for_paper: bool = False) -> Drawn:
    """Draw a report: page and text; only `for_paper` the figures as files, to which the text links then."""
    # Only who draws waits for what draws to be loaded.
    from cdp_ident.report.page.report_page import report_html  # noqa: PLC0415

    shown = figures(report, curves)
    return _drawn(
        TEXT, document_of(report), shown if for_paper else [], PAGE, lambda: report_html(report, curves, shown)
    )


def draw_comparison(document: Document, shown: Sequence[Figure]) -> Drawn:
    """Draw a comparison: page, text and figures."""
    from cdp_ident.report.page.rendering import render_page  # noqa: PLC0415

    return _drawn(COMPARISON_TEXT, document, shown, COMPARISON_PAGE, lambda: render_page(document, shown))


def _drawn(text: str, document: Document, on_paper: Sequence[Figure], name: str, page: Callable[[], str]) -> Drawn:
    files: dict[str, str | bytes] = {text: markdown(document, on_paper)}
    if on_paper:
        from cdp_ident.report.figures.for_paper import png_and_svg  # noqa: PLC0415

        for figure in on_paper:
            files[f"{FIGURES}/{figure.name}.png"], files[f"{FIGURES}/{figure.name}.svg"] = png_and_svg(figure)
    try:
        return Drawn({name: page(), **files})
    except ReportError as error:
        return Drawn(files, str(error))


def write_pictures(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write what was drawn; page and figures that were drawn there before go.

    Raises:
        OptionError: the folder or a file cannot be written.
    """
    write_files(folder, files, instead_of=(PAGE, *drawn_with(folder)))


def draw_again(folder: Path, for_paper: bool = False) -> str:
    """Draw the report in a folder anew, `for_paper` with figures; return why there is no page, where there is none.

    Raises:
        ReportError: there is no complete report in it.
        OptionError: it cannot be written to.
    """
    report = read_report(folder / REPORT)
    curves = read_curves(folder / CURVES, len(report["trials"]), len(report["effects"]))
    drawn = draw(report, curves, for_paper)
    write_pictures(folder, drawn.files)
    return drawn.problem
