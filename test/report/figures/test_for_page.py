# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Figures as plotly.js takes them; plotly itself says whether they are."""

import base64
import json
from itertools import pairwise

import numpy as np
import plotly.graph_objects
import pytest

from cdp_ident.report.chapters import document_of
from cdp_ident.report.figures.description import Axis, Figure, Line, Panel
from cdp_ident.report.figures.for_page import Arrays, plotly_figure
from cdp_ident.report.figures.palette import DARK, LIGHT


def completed(value, arrays, theme):
    """Return what the page makes of a figure."""
    if isinstance(value, dict) and set(value) == {"array"}:
        return np.frombuffer(base64.b64decode(arrays.texts[value["array"]]), "<f4")
    if isinstance(value, dict) and set(value) == {"colour"}:
        return theme[value["colour"]]
    if isinstance(value, dict):
        return {key: completed(inside, arrays, theme) for key, inside in value.items()}
    return [completed(inside, arrays, theme) for inside in value] if isinstance(value, list) else value


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_plotly_takes_every_figure(read_content, shown_curves, theme):
    arrays = Arrays()
    for figure in document_of(read_content, shown_curves).figures:
        drawn = plotly_figure(figure, arrays)
        json.dumps(drawn, allow_nan=False)
        plotly.graph_objects.Figure(completed(drawn, arrays, theme))


def test_panels_stand_one_below_the_other_without_touching(read_content, shown_curves):
    for figure in document_of(read_content, shown_curves).figures:
        layout = plotly_figure(figure, Arrays())["layout"]
        axes = [axis for name, axis in layout.items() if name.startswith("yaxis")]
        assert len(axes) == len(figure.panels)
        for upper, lower in pairwise(axes):
            assert upper["domain"][0] > lower["domain"][1]
        assert all(0 <= axis["domain"][0] < axis["domain"][1] <= 1 for axis in axes)
        assert len([name for name in layout if name.startswith("xaxis")]) == (1 if figure.shared_x else len(axes))


def test_upright_intervals_are_along_y():
    mark = Line("a", "ink", np.array([3.0]), np.array([1.0]), 0.0, shape="circle", half_widths=[0.2], upright=True)
    (trace,) = plotly_figure(Figure("f", "", "", "", [Panel(Axis(), Axis(), [mark])]), Arrays())["data"]
    assert (trace["mode"], trace["error_y"]["array"]) == ("markers", [0.2])
    assert "error_x" not in trace


def test_an_array_that_many_figures_show_is_kept_once():
    arrays = Arrays()
    time = np.linspace(0, 1, 5)
    assert arrays.keep(time) == arrays.keep(time.copy())
    assert len(arrays.texts) == 1
    arrays.keep(time + 1)
    assert len(arrays.texts) == 2


def test_four_bytes_a_number_are_enough_for_an_angle():
    arrays = Arrays()
    angles = np.array([6.123456789, np.nan])
    kept = np.frombuffer(base64.b64decode(arrays.texts[arrays.keep(angles)["array"]]), "<f4")
    assert kept[0] == pytest.approx(angles[0], abs=1e-6)
    assert np.isnan(kept[1])


def test_text_is_no_markup():
    evil = "<b>$x</b><img src=x onerror=alert(1)>"
    nothing = np.zeros(1)
    mark = Line(evil, "ink", nothing, nothing, hollow=[True], half_widths=[np.inf], words=[evil])
    panel = Panel(
        Axis(evil),
        Axis(ticks=[(0.0, evil)]),
        [mark, Line(evil, "ink", nothing, nothing, 0.0, shape="circle"), Line("a", "ink", nothing, nothing)],
        evil,
    )
    drawn = plotly_figure(Figure("f", evil, evil, evil, [panel]), Arrays())
    for trace in drawn["data"]:
        trace.pop("meta")  # only compared with what the legend's buttons say
    assert "<img" not in json.dumps(drawn)
