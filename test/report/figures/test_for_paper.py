# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Figures as files."""

import importlib
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

from cdp_ident.report.figures.description import Axis, Figure, Line, Panel


@pytest.fixture(scope="module")
def png_and_svg():
    """Loaded here: who draws nothing need not wait for what draws."""
    return importlib.import_module("cdp_ident.report.figures.for_paper").png_and_svg


def figure(text="name"):
    x = np.linspace(0, 1, 9)
    mark = Line(text, "ink", x[-1:], x[:1], 0.0, shape="star", hollow=[True], half_widths=[np.inf], words=[text])
    upright = Line(text, "ink", x[:1], x[:1], 0.0, half_widths=[0.1], upright=True)
    panels = [
        Panel(Axis(text), Axis(text), [Line(text, "after", x, x**2), upright]),
        Panel(Axis(), Axis(ticks=[(0, text)]), [mark]),
    ]
    return Figure("f", text, text, panels)


def test_both_kinds_of_file_come_out(png_and_svg):
    png, svg = png_and_svg(figure())
    assert png.startswith(b"\x89PNG")
    assert ElementTree.fromstring(svg).tag == "{http://www.w3.org/2000/svg}svg"


def test_the_same_figure_gives_the_same_bytes(png_and_svg):
    assert png_and_svg(figure()) == png_and_svg(figure())


@pytest.mark.parametrize("text", ["$", "$x$ and $\\frac{$", "a_b^c", "\\", "<script>alert(1)</script>&", "%s {0}"])
def test_text_stays_text(png_and_svg, text):
    _, svg = png_and_svg(figure(text))
    assert text in [
        "".join(element.itertext()).strip() for element in ElementTree.fromstring(svg).iter() if element.text
    ]


def test_nobody_else_s_settings_are_changed(png_and_svg):
    matplotlib = importlib.import_module("matplotlib")
    before = dict(matplotlib.rcParams)
    png_and_svg(figure())
    assert dict(matplotlib.rcParams) == before


def test_who_does_not_draw_does_not_load_what_draws():
    code = (
        "import sys, cdp_ident.pipeline.identifier, cdp_ident.commands.report, cdp_ident.commands.compare, "
        "cdp_ident.commands.survey; "
        "print([name for name in ('matplotlib', 'plotly', 'jinja2') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"
