"""A document as a page that needs nothing beside itself; text from bags and files stays text."""

import base64
import gzip
import hashlib
from functools import cache
from typing import Any

import jinja2
from markupsafe import Markup

from cdp_ident.errors import ReportError
from cdp_ident.report.figures.for_page import Arrays, plotly_figure
from cdp_ident.report.figures.palette import DARK, LIGHT
from cdp_ident.report.parts import Document

_LOADER = jinja2.PackageLoader("cdp_ident.report.page", "templates")


def render_page(
    document: Document,
    template: str = "document.html",
    content: dict[str, Any] | None = None,
    data: dict[str, Any] | None = None,
    arrays: Arrays | None = None,
    scripts: tuple[str, ...] = ("charts.js",),
) -> str:
    """Return a document as a page.

    Args:
        document: what it says.
        template: its name.
        content: what the template takes beside the document, by name.
        data: what the scripts take beside the figures.
        arrays: where the arrays of `data` are kept.
        scripts: names of its own scripts.

    Raises:
        ReportError: plotly, which draws the charts, is not installed.
    """
    environment, plotly, arrays = _pages(), _plotly(), arrays or Arrays()
    drawn = {figure.name: plotly_figure(figure, arrays) for figure in document.figures}
    return environment.get_template(template).render(
        document=document,
        style=Markup(environment.get_template("style.css").render(light=LIGHT, dark=DARK)),
        plotly=plotly,
        packed=_packed(plotly),
        scripts=[Markup(_LOADER.get_source(environment, name)[0]) for name in scripts],
        digest=_digest,
        data={"arrays": arrays.texts, "figures": drawn, "themes": {"light": LIGHT, "dark": DARK}, **(data or {})},
        **(content or {}),
    )


@cache
def _pages() -> jinja2.Environment:
    """Return what holds the templates of pages, each of which is compiled once: that takes 0.05 s for a report."""
    return jinja2.Environment(loader=_LOADER, autoescape=True, undefined=jinja2.StrictUndefined)


def _plotly() -> Markup:
    try:
        from plotly.offline import get_plotlyjs  # noqa: PLC0415
    except ImportError as error:
        raise ReportError(
            "there is no page without plotly: pip install plotly (with --break-system-packages beside ROS's own Python)"
        ) from error
    return Markup(get_plotlyjs())


@cache
def _packed(script: str) -> str:
    """Return a script as base64 of gzip, which a browser unpacks: plotly.js is 4.8 MB, and 1.9 MB then."""
    return base64.b64encode(gzip.compress(script.encode(), mtime=0)).decode("ascii")


def _digest(script: Markup) -> str:
    """Return what the page names a script by: the browser runs no other."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
