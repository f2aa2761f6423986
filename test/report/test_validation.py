# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well the models follow the motion, in words and pictures."""

import numpy as np
import pytest

from cdp_ident.report.validation import before_and_after, prediction, residual_correlation, validation_words


def test_the_validation_is_in_words(read_content):
    fit, ahead, residuals = validation_words(read_content)
    percent = read_content["after"]["error"]["holdout"]["fit_theta2_percent"]
    assert f"-> {percent:.4g} %" in fit
    assert "within 1° for " in ahead
    assert f"-> ≥ {read_content['prediction']['horizon_s']:.3g} s" in ahead
    assert residuals == "residuals over held-out windows: white"


def test_residuals_that_are_not_white_are_told_with_how_much_they_are_correlated(read_content):
    found = read_content["residuals"]
    cart = {angle: found["before"][angle] for angle in ("theta1", "theta2")}
    found["after"] = found["before"] | {"cart": cart, "crosswise": found["before"]["crosswise"] | {"related": True}}
    *_, own, crosswise, cart = validation_words(read_content)
    most = max(map(abs, found["before"]["theta1"]["values"][1:]))
    assert f"{most:.2f} in theta1 (chance: " in own
    assert "each other" in crosswise
    assert "cart's acceleration" in cart


def test_what_has_no_prediction_and_no_fit_says_nothing_of_it(read_content):
    read_content["prediction"] = None
    read_content["before"]["error"]["holdout"]["fit_theta1_percent"] = np.inf
    words = list(validation_words(read_content))
    assert "theta1 – -> " in words[0]
    assert not any("predicts" in word for word in words)


def test_errors_stand_beside_the_noise(read_content):
    figure = before_and_after(read_content)
    before, after, noise = figure.panels[0].marks
    errors = read_content["before"]["error"]
    assert before.x == pytest.approx([1e3 * errors[role]["rmse_rad"] for role in ("holdout", "fit")])
    assert max(after.x) < min(before.x) / 10
    assert noise.x[0] == noise.x[1] == pytest.approx(0.278, rel=0.03)
    assert f"held out {before.x[0]:.3g}, fitted" in figure.alternative


def test_the_growth_of_the_error_is_drawn_before_and_after(read_content):
    (figure,) = prediction(read_content)
    lines = {line.label: line for line in figure.panels[0].marks}
    before, after = (line for label, line in lines.items() if "model" in label or "effects" in label)
    assert after.y == pytest.approx(np.degrees(read_content["prediction"]["after"]["median_rad"]))
    assert np.median(after.y) < np.median(before.y) / 10
    assert np.all(lines["5°"].y == 5)


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


def test_the_cart_has_panels_where_it_moves(read_content):
    for model in ("before", "after"):
        of = read_content["residuals"][model]
        of["cart"] = {"theta1": of["crosswise"], "theta2": of["crosswise"]}
    assert len(residual_correlation(read_content).panels) == 5
