# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a figure says about itself, in colours that everybody can tell apart, on either ground."""

import itertools

import numpy as np
import pytest

from cdp_ident.report.figures.description import (
    DARK,
    LIGHT,
    SERIES,
    SHAPES,
    Axis,
    Bars,
    Figure,
    Heat,
    Line,
    Panel,
    level,
    named,
    series,
)

NOTHING = np.zeros(2)


def test_the_legend_has_each_name_once_with_colour_and_kind():
    marks = [
        Line("a", "ink", NOTHING, NOTHING),
        Line("b", "before", NOTHING, NOTHING, dash="dash"),
        level("n", "noise", 1.0, named("ab")),
        Line("t", "before", NOTHING, NOTHING, width=0.6),
    ]
    again = [
        Line("a", "ink", NOTHING, NOTHING),
        Line("d", "after", NOTHING, NOTHING, 0.0, shape="circle"),
        Bars("e", "after", [0], [1], ["1"]),
    ]
    panels = [Panel(Axis(), Axis(), marks), Panel(Axis(), Axis(), again, held_out=[(0.0, 1.0)])]
    assert Figure("f", "", "", panels).legend() == [
        ("a", "ink", "solid"),
        ("b", "before", "dash"),
        ("n", "noise", "dot"),
        ("t", "before", "thin"),
        ("d", "after", "circle"),
        ("e", "after", "bars"),
        ("held out", "held_out", "span"),
    ]


def test_a_square_of_numbers_needs_no_legend():
    assert Figure("f", "", "", [Panel(Axis(), Axis(), [Heat(np.eye(1))])]).legend() == []


def test_what_a_figure_shows_is_in_words_for_those_who_cannot_see_it():
    names = named(["rod", "cart"])
    bars = Bars("of one", "after", [3.0, 4.0], [0.1, 1.1], ["3 mm", "4 mm"])
    dots = Line("of another", "ink", np.ones(1), np.ones(1), 0.0, shape="circle", words=["1 mm"])
    beside_names = Panel(Axis("length [mm]"), names, [bars, dots, level("all", "noise", 2.0, names)])
    line = Line("a", "ink", np.arange(3.0), np.array([np.nan, -1.0, 2.0]))
    lost = Line("b", "ink", np.arange(2.0), np.full(2, np.nan))
    over_time = Panel(Axis("time [s]"), Axis("angle [rad]"), [line, lost])
    square = Panel(Axis(), Axis(), [Heat(np.array([[1.0, 0.5]]))], "of all")
    assert Figure("f", "Rods", "", [beside_names, over_time, square]).alternative == (
        "Rods. length [mm]: of one rod 3 mm, cart 4 mm; of another cart 1 mm; all 2. "
        "angle [rad]: a -1 to 2; b nothing. of all: 0.5 to 1."
    )


# Machado, Oliveira and Fernandes, IEEE Trans. Visualization and Computer Graphics 15, 2009, full severity, linear RGB.
DEFICIENCIES = {
    "none": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def linear(colour):
    value = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ np.clip(rgb, 0, 1)
    f = np.cbrt(xyz / [0.9505, 1.0, 1.089] + 1e-6)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def contrast(one, other):
    bright, dim = sorted((float(linear(c) @ [0.2126, 0.7152, 0.0722]) for c in (one, other)), reverse=True)
    return (bright + 0.05) / (dim + 0.05)


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize("vision", DEFICIENCIES)
def test_models_can_be_told_apart_by_everybody(theme, vision):
    seen = {
        name: lab(np.array(DEFICIENCIES[vision]) @ linear(theme[name]))
        for name in ("before", "after", "ink", "surface")
    }
    for one, other in itertools.combinations(seen, 2):
        assert np.linalg.norm(seen[one] - seen[other]) > 20, (one, other)


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
def test_text_and_curves_stand_out_from_the_ground(theme):
    assert contrast(theme["ink"], theme["surface"]) > 7
    assert contrast(theme["quiet"], theme["surface"]) > 4.5
    assert all(contrast(theme[name], theme["surface"]) > 2.7 for name in ("before", "after", *SERIES))


def test_both_themes_have_every_colour():
    assert set(LIGHT) == set(DARK)


def test_more_runs_than_colours_begin_anew():
    assert series(0) == ("series1", "circle") == series(len(SERIES))
    assert len(set(SHAPES)) == len(SERIES)
