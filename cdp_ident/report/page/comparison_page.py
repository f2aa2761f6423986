"""`compare.html` and `compare.md`: several reports side by side."""

from collections.abc import Sequence

from markupsafe import Markup

from cdp_ident.report.comparison import Run, compare
from cdp_ident.report.figures.description import Figure
from cdp_ident.report.figures.for_page import Arrays
from cdp_ident.report.figures.parameters import estimates_against
from cdp_ident.report.formatting import number
from cdp_ident.report.page.rendering import render_page, render_text


def comparison_figures(runs: Sequence[Run]) -> list[Figure]:
    """Return the runs' base parameters against those of the first."""
    first = runs[0]
    groups = {name: number(quantity["value"]) for name, quantity in first.report["after"]["groups"].items()}
    figure = Figure(
        "compare_groups",
        "compare",
        f"Base parameters against those of {first.name}",
        "Of each final model, with 95 % intervals.",
        "",
        (),
    )
    estimates = [(run.name, run.report["after"]["groups"]) for run in runs]
    return [estimates_against(estimates, groups, figure, f"difference from {first.name} [%]", "no difference")]


def comparison_html(runs: Sequence[Run], shown: list[Figure]) -> str:
    """Return `compare.html`.

    Raises:
        ReportError: plotly is not installed.
    """
    return render_page("compare.html", shown, _content(runs), {}, Arrays(), ("charts.js",))


def comparison_md(runs: Sequence[Run], shown: list[Figure], folder: str) -> str:
    """Return `compare.md`, whose figures are SVG files in a folder beside it."""
    return render_text(
        "compare.md", shown, {**_content(runs), "picture": lambda figure: Markup(f"{folder}/{figure.name}.svg")}
    )


def _content(runs: Sequence[Run]) -> dict[str, object]:
    return {"names": [run.name for run in runs], "tables": compare(runs)}
