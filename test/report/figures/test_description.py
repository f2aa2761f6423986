# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a figure says about itself."""

import numpy as np

from cdp_ident.report.figures.description import Axis, Bars, Figure, Heat, Line, Panel, level, named

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
    assert Figure("f", "", "", "", panels).legend() == [
        ("a", "ink", "solid"),
        ("b", "before", "dash"),
        ("n", "noise", "dot"),
        ("t", "before", "thin"),
        ("d", "after", "circle"),
        ("e", "after", "bars"),
        ("held out", "held_out", "span"),
    ]


def test_a_square_of_numbers_needs_no_legend():
    assert Figure("f", "", "", "", [Panel(Axis(), Axis(), [Heat(np.eye(1))])]).legend() == []
