# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Maps of what a next trial would tell."""

import numpy as np
import pytest

from cdp_ident.report.advice import advice_map


def test_the_map_has_each_start_and_at_the_one_to_take_a_dot_and_what_the_words_say(read_content):
    (figure,) = advice_map(read_content)
    advice = read_content["next_trial"]["advice"][0]
    heat, dot = figure.panels[0].marks
    inner, outer = (int(place[0]) for place in (dot.x, dot.y))
    assert np.degrees(advice["inner_rad"]) == pytest.approx(np.degrees(advice["map"]["inner_rad"][inner]))
    assert heat.matrix[outer, inner] == 100.0 * advice["expected"]
    assert f"fall to {heat.matrix[outer, inner]:.2g} %" in figure.alternative
    others = np.delete(heat.matrix.ravel(), outer * heat.matrix.shape[1] + inner)
    exact = 100.0 * np.array(advice["map"]["values"])
    assert np.isin(others, exact).all()
    assert figure.panels[0].title == "all base parameters [%]"
    assert "all base parameters: let go" in figure.alternative


def test_starts_without_a_motion_are_left_blank(read_content):
    read_content["next_trial"]["advice"][0]["map"]["values"][0] = [np.inf] * 8
    (figure,) = advice_map(read_content)
    assert not np.isfinite(figure.panels[0].marks[0].matrix[:, 0]).any()


def test_two_effects_have_a_scale_of_their_own(read_content):
    advice = read_content["next_trial"]["advice"][0]
    advice["against"] = "air_drag.outer"
    advice["map"]["values"] = [[7.0] * 12 for _ in range(12)]
    (figure,) = advice_map(read_content)
    assert figure.panels[0].marks[0].limits == (-7.0, 7.0)


def test_what_no_trial_shows_yet_is_drawn_by_its_interval_then_and_starts_that_show_nothing_are_left_blank(
    read_content,
):
    (figure,) = advice_map(read_content)
    advice, panel = read_content["next_trial"]["advice"][-1], figure.panels[-1]
    assert panel.title == "A22, with a weight [± %]"
    heat = panel.marks[0]
    shown = heat.matrix[np.isfinite(heat.matrix)]
    assert 1.96 <= shown.min() <= shown.max() == heat.limits[1] / 2
    assert shown.max() < 100
    hanging = advice["map"]["values"][advice["map"]["inner_rad"].index(0.0)][advice["map"]["outer_rad"].index(0.0)]
    assert hanging == np.inf
