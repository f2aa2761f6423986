"""Missing torques, and the fitted effects through them."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.report.figures.torques import effects_through_residuals, missing_torques, torques_without_a_name


def test_there_is_a_panel_for_each_joint_over_speed_and_over_angle(read_content, shown_curves):
    figures = list(missing_torques(read_content, shown_curves))
    assert [figure.name for figure in figures] == ["torque_over_speed", "torque_over_angle"]
    for figure in figures:
        assert [panel.y.label for panel in figure.panels] == ["inner joint [mN m]", "outer joint [mN m]"]
        assert "rad/s" in figure.panels[0].x.label or "angle" in figure.panels[0].x.label


def test_the_mean_steps_at_rest_before_and_not_after(read_content, shown_curves):
    outer = next(missing_torques(read_content, shown_curves)).panels[1]
    means = {mark.label: mark for mark in outer.marks if mark.label.startswith("mean")}

    def step(mean):
        return mean.y[(mean.x > -3) & (mean.x < -0.5)].mean() - mean.y[(mean.x < 3) & (mean.x > 0.5)].mean()

    assert step(means["mean before"]) > 2.0
    assert abs(step(means["mean after"])) < 0.6


def test_the_effect_runs_through_what_is_missing_without_it(read_content, shown_curves):
    (figure,) = effects_through_residuals(read_content, shown_curves)
    cloud, mean, fitted = figure.panels[0].marks
    assert set(np.sign(fitted.y) * np.sign(fitted.x)) <= {-1.0, 0.0}
    assert np.abs(fitted.y).max() == pytest.approx(
        1e3 * read_content["effects"][0]["parameters"]["torque"]["value"], rel=2e-3
    )
    far = np.abs(mean.x) > 1
    along = np.interp(mean.x, *np.stack([fitted.x, fitted.y])[:, np.argsort(fitted.x)])
    assert mean.y[far] == pytest.approx(along[far], abs=1.0)
    assert len(cloud.x) <= 1500
    assert read_content["effects"][0]["formula"] in figure.caption


def test_an_encoder_s_effect_has_no_torque_to_draw(read_content, shown_curves):
    nothing = replace(shown_curves.torques, effects=np.zeros_like(shown_curves.torques.effects))
    assert list(effects_through_residuals(read_content, replace(shown_curves, torques=nothing))) == []


def test_angles_are_shown_within_a_turn(read_content, shown_curves):
    turned = replace(shown_curves.torques, angle=shown_curves.torques.angle + 6 * np.pi)
    _, figure = missing_torques(read_content, replace(shown_curves, torques=turned))
    assert all(np.abs(mark.x).max() <= np.pi for panel in figure.panels for mark in panel.marks)


def test_a_few_wild_dots_do_not_squeeze_the_rest(read_content, shown_curves):
    before = shown_curves.torques.before.copy()
    before[::1000] = 1e3
    _, outer = next(
        missing_torques(read_content, replace(shown_curves, torques=replace(shown_curves.torques, before=before)))
    ).panels
    low, high = outer.y.limits
    assert low == -high
    assert high < 20.0


def test_a_torque_without_a_name_is_drawn_with_its_band(read_content):
    assert list(torques_without_a_name(read_content)) == []
    curve = {"over": "angle", "at": [-1.0, 0.0, 1.0], "torque": [0.0, 0.02, 0.01], "std": [1e-3, 2e-3, 1e-3]}
    curve |= {"coefficients": [0.0], "coefficients_std": [0.0], "likeness": "a magnet at 0 rad"}
    effect = read_content["effects"][0] | {"curve": curve, "name": "unknown_torque"}
    (figure,) = torques_without_a_name(read_content | {"effects": [effect]})
    torque, above, below = figure.panels[0].marks
    assert torque.y.tolist() == [0.0, 20.0, 10.0]
    assert above.y - torque.y == pytest.approx(torque.y - below.y)
    assert above.y[1] - torque.y[1] == pytest.approx(3.92, abs=0.01)
    assert "like that of a magnet at 0 rad" in figure.caption
