"""How far ahead the models predict, and what is left in their residuals."""

import numpy as np
import pytest

from cdp_ident.report.figures.validation import prediction, residual_correlation


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
