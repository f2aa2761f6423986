"""Fills the templates, and makes sure that text from bags and files stays text."""

import base64
import gzip
import hashlib
import re
from collections.abc import Sequence
from functools import cache
from typing import Any, get_args

import jinja2
from markupsafe import Markup

from cdp_ident.errors import ReportError
from cdp_ident.report.figures.description import Figure, Place
from cdp_ident.report.figures.for_page import Arrays, plotly_figure
from cdp_ident.report.figures.palette import DARK, LIGHT
from cdp_ident.report.folder import FIGURES

_LOADER = jinja2.PackageLoader("cdp_ident.report.page", "templates")
_MARKDOWN = re.compile(r"([\\`*_\[\]#|~])")


def render_page(
    template: str,
    shown: Sequence[Figure],
    content: dict[str, Any],
    data: dict[str, Any],
    arrays: Arrays,
    scripts: tuple[str, ...],
) -> str:
    """Return a page that needs nothing beside itself.

    Args:
        template: its name.
        shown: the figures of the page.
        content: what the template takes, by name.
        data: what the scripts take beside the figures.
        arrays: where the arrays of `data` are kept.
        scripts: names of its own scripts.

    Raises:
        ReportError: plotly, which draws the charts, is not installed.
    """
    environment = _pages()
    plotly = _plotly()
    drawn = {figure.name: plotly_figure(figure, arrays) for figure in shown}
    return environment.get_template(template).render(
        **content,
        figures=_by_place(shown),
        style=Markup(environment.get_template("style.css").render(light=LIGHT, dark=DARK)),
        plotly=plotly,
        packed=_packed(plotly),
        scripts=[Markup(_source(environment, name)) for name in scripts],
        digest=_digest,
        data={"arrays": arrays.texts, "figures": drawn, "themes": {"light": LIGHT, "dark": DARK}, **data},
    )


def render_text(template: str, shown: Sequence[Figure], content: dict[str, Any]) -> str:
    """Return a Markdown text with links to the figures' SVG files, in a folder beside it."""

    def picture(figure: Figure) -> Markup:
        return Markup(f"{FIGURES}/{figure.name}.svg")

    return _texts().get_template(template).render(**content, figures=_by_place(shown), picture=picture)


@cache
def _pages() -> jinja2.Environment:
    """Return what holds the templates of pages, each of which is compiled once: that takes 0.05 s for a report."""
    return jinja2.Environment(loader=_LOADER, autoescape=True, undefined=jinja2.StrictUndefined)


@cache
def _texts() -> jinja2.Environment:
    """Return what holds the templates of texts in Markdown."""
    environment = jinja2.Environment(
        loader=_LOADER,
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=_as_markdown,
        keep_trailing_newline=True,
    )
    environment.filters["code"] = _as_code
    return environment


def _by_place(shown: Sequence[Figure]) -> dict[str, list[Figure]]:
    return {place: [figure for figure in shown if figure.section == place] for place in get_args(Place)}


def _as_markdown(value: Any) -> Any:
    """Escape text that is put into a template, so that nothing in it is taken for Markdown or HTML."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    return Markup(_MARKDOWN.sub(r"\\\1", " ".join(value.split()).replace("&", "&amp;").replace("<", "&lt;")))


def _as_code(text: str) -> Markup:
    return Markup("`{}`").format(Markup(" ".join(text.split()).replace("`", "'")))


def _source(environment: jinja2.Environment, name: str) -> str:
    source, _, _ = _LOADER.get_source(environment, name)
    return source


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
