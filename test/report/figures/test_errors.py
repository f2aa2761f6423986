# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The errors before and after, of the search, and along the selection of effects."""

import numpy as np
import pytest

from cdp_ident.report.figures.description import Bars
from cdp_ident.report.figures.errors import (
    before_and_after,
    best_error,
    candidates,
    prediction,
    residual_correlation,
    selection,
)
from cdp_ident.report.wording import chance, odds


def test_errors_stand_beside_the_noise(read_content):
    figure = before_and_after(read_content)
    before, after, noise = figure.panels[0].marks
    errors = read_content["before"]["error"]
    assert before.lengths == pytest.approx([1e3 * errors[role]["rmse_rad"] for role in ("holdout", "fit")])
    assert max(after.lengths) < min(before.lengths) / 10
    assert noise.x[0] == noise.x[1] == pytest.approx(0.278, rel=0.03)
    assert f"{before.lengths[0]:.3g} mrad held out" in figure.alternative


def test_the_history_of_a_search_in_full_is_shown(read_content):
    assert not list(best_error(read_content))
    read_content["search"] |= {"history": [100.0, 5.0, 0.1], "cut_short": False}
    (figure,) = best_error(read_content)
    assert figure.panels[0].y.logarithmic
    assert np.array_equal(figure.panels[0].marks[0].y, [100.0, 5.0, 0.1])


@pytest.fixture
def with_many_tried(read_content):
    """The report, as if more had been tried at the first step, and that had been the only one."""
    keys = ("air_drag.outer.strips", "load_friction.outer", "quadratic_friction.outer", "encoder_offset.outer")
    others = [{"effects": [key], "log10_odds": -float(k)} for k, key in enumerate(keys)]
    tried = [others[0], {"effects": ["coulomb_friction.outer"], "log10_odds": 400.0}, *others[1:]]
    read_content["selection"]["steps"] = [
        {"action": "added coulomb_friction.outer", "log10_odds": 400.0, "tried": tried}
    ]
    return read_content


def test_every_effect_that_was_tried_is_in_the_picture_and_the_taken_one_stands_out(with_many_tried):
    (figure,) = selection(with_many_tried)
    panel = figure.panels[0]
    tried = with_many_tried["selection"]["steps"][0]["tried"]
    assert [name.replace("\n", " ") for _, name in panel.y.ticks][:1] == ["air drag, outer, strips"]
    bars = {mark.label: mark for mark in panel.marks if isinstance(mark, Bars)}
    assert list(bars["taken"].lengths) == [400.0]
    assert len(bars["tried, not taken"].lengths) == len(tried) - 1
    place = [position for position, _ in panel.y.ticks].index(bars["taken"].positions[0])
    assert tried[place]["effects"] == ["coulomb_friction.outer"]
    assert panel.title == "Step 1: added coulomb friction, outer"
    assert panel.marks[-1].x.tolist() == [0.0, 0.0]


def test_where_nothing_helps_nothing_stands_out(with_many_tried):
    step = with_many_tried["selection"]["steps"][0]
    step["tried"] = [one for one in step["tried"] if one["log10_odds"] < 0]
    (figure,) = selection(with_many_tried)
    assert [mark.label for mark in figure.panels[0].marks] == ["tried, not taken", "as probable as before"]


def test_a_name_of_many_lines_has_room_of_its_own(with_many_tried):
    tried = with_many_tried["selection"]["steps"][0]["tried"]
    tried[1]["effects"] = ["encoder_eccentricity.outer", "encoder_eccentricity.inner", "gravity_tilt.base"]
    (figure,) = selection(with_many_tried)
    positions = [position for position, _ in figure.panels[0].y.ticks]
    lines = figure.panels[0].y.ticks[1][1].count("\n") + 1
    assert lines > 2
    assert positions[2] - positions[1] > positions[4] - positions[3]
    assert figure.panels[0].height / (positions[-1] - positions[0] + 1) * (positions[2] - positions[0]) > 13 * (
        lines + 1
    )


def test_what_could_not_be_fitted_has_no_bar(with_many_tried):
    tried = with_many_tried["selection"]["steps"][0]["tried"]
    tried[-1]["log10_odds"], tried[-2]["log10_odds"] = np.inf, np.nan
    (figure,) = selection(with_many_tried)
    assert len(figure.panels[0].y.ticks) == len(tried) - 2
    for one in tried:
        one["log10_odds"] = np.inf
    assert list(selection(with_many_tried)) == []


def test_every_effect_that_was_looked_for_has_a_bar_with_its_odds_and_probability(read_content):
    (figure,) = candidates(read_content)
    (panel,) = figure.panels
    looked_for = {tuple(one["effect"].split(".")[:2]) for one in read_content["selection"]["candidates"]}
    assert len(panel.y.ticks) == len(looked_for)
    best = read_content["selection"]["candidates"][0]
    assert panel.marks[0].lengths[0] == best["log10_odds"]
    assert panel.marks[0].words[0] == f"{odds(best['log10_odds'])}, {chance(best['probability'])}"


def test_the_growth_of_the_error_is_drawn_before_and_after(read_content):
    (figure,) = prediction(read_content)
    lines = {line.label: line for line in figure.panels[0].marks}
    before, after = (line for label, line in lines.items() if "model" in label or "effects" in label)
    assert after.y == pytest.approx(np.degrees(read_content["prediction"]["after"]["median_rad"]))
    assert np.median(after.y) < np.median(before.y) / 10
    assert np.all(lines["5°"].y == 5)
    assert "within 1° for" in figure.alternative


def test_where_a_prediction_diverges_its_curve_ends(read_content):
    read_content["prediction"]["before"]["median_rad"][-10:] = [np.inf] * 10
    (figure,) = prediction(read_content)
    assert np.isnan(figure.panels[0].marks[0].y[-10:]).all()


def test_the_correlations_have_their_lags_and_bounds(read_content):
    figure = residual_correlation(read_content)
    own, _, crosswise = figure.panels
    found = read_content["residuals"]
    assert own.marks[1].x[:3] == pytest.approx([0, 5, 10], rel=0.01)
    assert crosswise.marks[1].x[len(crosswise.marks[1].x) // 2] == 0
    assert own.marks[1].y == pytest.approx(found["after"]["theta1"]["values"])
    assert {abs(float(mark.y[0])) for mark in own.marks[2:]} == {found["after"]["theta1"]["bound"]}
    assert "after: with the effects found: white" in figure.alternative
    assert "before: the paper's model, fitted: correlated in time" in figure.alternative


def test_the_cart_has_panels_where_it_moves(read_content):
    for model in ("before", "after"):
        of = read_content["residuals"][model]
        of["cart"] = {"theta1": of["crosswise"], "theta2": of["crosswise"]}
    assert len(residual_correlation(read_content).panels) == 5
