# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A report is drawn from its numbers and curves alone, and plotly itself says whether its figures are what it takes."""

import base64
import json
import re
from itertools import pairwise

import numpy as np
import plotly.graph_objects
import pytest

from cdp_ident.report.chapters import document_of
from cdp_ident.report.figures.description import DARK, LIGHT, Axis, Figure, Line, Panel
from cdp_ident.report.folder import FIGURES, PAGE, TEXT
from cdp_ident.report.pictures import Arrays, plotly_figure

PICTURES = {
    "errors", "candidates", "angles_1_swing_wide", "angles_2_swing_folded", "angles_3_swing_check",
    "contrast_1_swing_wide", "contrast_2_swing_folded", "contrast_3_swing_check",
    "selection", "torque_over_time",
    "torque_over_speed", "torque_over_angle", "prediction", "residual_correlation", "next_trial",
    "effect_1_coulomb_friction_outer", "parameters", "correlation", "repeatability",
}  # fmt: skip


def test_every_picture_is_there_as_png_and_svg(report_folder):
    names = {path.name for path in (report_folder / FIGURES).iterdir()}
    assert names == {f"{name}.{kind}" for name in PICTURES for kind in ("png", "svg")}


def test_the_page_is_one_file_of_less_than_2_mb(report_folder):
    assert (report_folder / PAGE).stat().st_size < 2_000_000


def test_the_text_has_the_verdict_the_numbers_and_links_to_figures_that_are_there(report_folder, read_content):
    text = (report_folder / TEXT).read_text()
    assert read_content["verdict"] in text
    links = re.findall(r"\]\((figures/\S+)\)", text)
    assert len(links) == len(PICTURES)
    assert all((report_folder / link).exists() for link in links)
    assert "dry friction (outer joint) | torque | 0.0336" in text


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
    (trace,) = plotly_figure(Figure("f", "", "", [Panel(Axis(), Axis(), [mark])]), Arrays())["data"]
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
    drawn = plotly_figure(Figure("f", evil, evil, [panel]), Arrays())
    for trace in drawn["data"]:
        trace.pop("meta")  # only compared with what the legend's buttons say
    assert "<img" not in json.dumps(drawn)
