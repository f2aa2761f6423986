# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Angles over time, missing torques, and the fitted effects through them."""

from dataclasses import fields, replace

import numpy as np
import pytest

from cdp_ident.report.curves import NO_WINDOW
from cdp_ident.report.figures.curves import (
    angles,
    continuous_runs,
    effects_through_residuals,
    file_name,
    missing_torques,
    nonparametric_torques,
    shown_samples,
)


def test_each_trial_has_its_angles_and_beneath_them_what_is_left(read_content, shown_curves):
    figures = list(angles(read_content, shown_curves))
    assert [figure.title for figure in figures] == [
        "Angles of swing_wide (fitted)",
        "Angles of swing_folded (fitted)",
        "Angles of swing_check (held out)",
    ]
    figure, curve = figures[2], shown_curves.trials[2]
    assert figure.shared_x
    assert [panel.y.label for panel in figure.panels] == [
        "θ1 [rad]",
        "θ2 [rad]",
        "error of θ1 [mrad]",
        "error of θ2 [mrad]",
    ]
    measured, before, after = figure.panels[1].marks
    assert np.array_equal(measured.y, curve.measured[:, 1])
    left_before, left_after = figure.panels[3].marks
    assert left_before.y == pytest.approx(1e3 * (measured.y - before.y))
    assert left_after.y == pytest.approx(1e3 * (measured.y - after.y))
    assert (before.dash, after.dash) == ("dash", "solid")
    assert (left_before.label, left_before.colour) == (before.label, before.colour)


def test_the_paper_s_figures_are_of_one_continuous_run(read_content, shown_curves):
    contrast, *_ = continuous_runs(read_content, shown_curves)
    curve = shown_curves.trials[0]
    assert np.array_equal(contrast.panels[0].marks[2].y, curve.run_after[:, 0])
    assert contrast.panels[2].marks[1].y == pytest.approx(1e3 * (curve.measured - curve.run_after)[:, 0])
    assert "Eq. 10" in contrast.caption


def test_without_effects_there_is_one_model(read_content, shown_curves):
    figure = next(angles(read_content | {"effects": []}, shown_curves))
    assert [mark.label for mark in figure.panels[0].marks] == ["measured", "before: the paper's model, fitted"]


def test_windows_kept_out_are_marked_where_others_of_the_trial_were_fitted(read_content, shown_curves):
    trial = shown_curves.trials[0]
    partly = replace(trial, held_out=trial.window == 2)
    figure = next(angles(read_content, replace(shown_curves, trials=(partly, *shown_curves.trials[1:]))))
    ((begin, end),) = figure.panels[0].held_out
    third = trial.time[trial.window == 2]
    assert [begin, end] == [third[0], third[-1]]
    assert "held out" in [label for label, _, _ in figure.legend()]
    assert all(not figure.panels[0].held_out for figure in angles(read_content, shown_curves))


def test_samples_outside_all_windows_are_marked_nowhere(read_content, shown_curves):
    trial = shown_curves.trials[0]
    window = np.where(trial.time < 1.0, NO_WINDOW, trial.window)
    partly = replace(trial, window=window, held_out=trial.window == 4)
    figure = next(angles(read_content, replace(shown_curves, trials=(partly, *shown_curves.trials[1:]))))
    assert len(figure.panels[0].held_out) == 1


def test_long_trials_are_thinned_and_it_is_said(read_content, shown_curves, monkeypatch):
    monkeypatch.setattr("cdp_ident.report.figures.curves.MOST_SAMPLES", 2500)
    assert shown_samples(shown_curves).step == 3
    figure = next(angles(read_content, shown_curves))
    assert len(figure.panels[0].marks[0].x) == pytest.approx(len(shown_curves.trials[0].time) / 3, abs=1)
    assert "One of 3 samples is shown" in figure.caption


@pytest.mark.parametrize("name", ["../../etc/passwd", "a b/c", '"><img src=x>', "x" * 500, "日本", ""])
def test_a_trial_s_name_cannot_lead_a_file_elsewhere(name):
    safe = file_name(name)
    assert len(safe) <= 40
    assert not set(safe) - set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")


@pytest.fixture
def read_content(read_content):
    """The report of a rig that was weighed."""
    read_content["after"]["physical"]["A22"]["std"] = 1e-3
    return read_content


def test_torques_are_over_the_inertia_where_no_mass_is_known(read_content, shown_curves):
    weighed = next(missing_torques(read_content, shown_curves)).panels[0]
    inertia = read_content["after"]["physical"]["A22"]
    inertia["std"] = 2 * inertia["value"]
    figure = next(missing_torques(read_content, shown_curves))
    assert figure.panels[0].y.label == "outer joint [1/s²]"
    assert figure.panels[0].marks[0].y == pytest.approx(1e-3 / inertia["value"] * weighed.marks[0].y, nan_ok=True)
    assert "Over A22" in figure.caption


def test_there_is_a_panel_for_each_joint_that_lacks_a_torque(read_content, shown_curves):
    missing = shown_curves.before.missing.copy()
    missing[:, 0] = 1e-3
    both = replace(shown_curves, before=replace(shown_curves.before, missing=missing))
    figures = list(missing_torques(read_content, both))
    assert [figure.name for figure in figures] == ["torque_over_speed", "torque_over_time", "torque_over_angle"]
    for figure in figures[::2]:
        assert [panel.y.label for panel in figure.panels] == ["inner joint [mN m]", "outer joint [mN m]"]
        assert "rad/s" in figure.panels[0].x.label or "angle" in figure.panels[0].x.label
    over_speed, over_time, _ = missing_torques(read_content, shown_curves)
    assert [panel.y.label for panel in over_speed.panels] == ["outer joint [mN m]"]
    assert [panel.title for panel in over_time.panels][:2] == ["swing_wide, outer joint", "swing_folded, outer joint"]


def test_where_nothing_is_missing_there_is_no_picture_of_it(read_content, shown_curves):
    nothing = {
        part: replace(torques, missing=np.zeros_like(torques.missing), std=np.zeros_like(torques.std))
        for part, torques in (("before", shown_curves.before), ("after", shown_curves.after))
    }
    assert list(missing_torques(read_content, replace(shown_curves, **nothing))) == []


def test_over_time_there_is_a_band_and_lines_end_where_motion_is_interrupted(read_content, shown_curves):
    torques = shown_curves.before
    kept = (torques.trial != 0) | (torques.time < 3.0) | (torques.time > 5.0)
    parts = {f.name: getattr(torques, f.name)[kept] for f in fields(torques) if f.name != "effects"}
    interrupted = replace(torques, **parts, effects=torques.effects[:, kept])
    _, over_time, _ = missing_torques(read_content, replace(shown_curves, before=interrupted))
    line, band = over_time.panels[0].marks[:2]
    assert line.dash == "dash"
    assert np.count_nonzero(np.isnan(line.x)) == 1
    assert len(band.x) == 2 * len(line.x) + 1
    above, below = band.y[: len(line.y)], band.y[len(line.y) + 1 :]
    assert np.nanmean(above - below) == pytest.approx(2e3 * interrupted.std[interrupted.trial == 0, 1].mean())


def test_the_mean_steps_at_rest_before_and_not_after(read_content, shown_curves):
    over_speed, *_ = missing_torques(read_content, shown_curves)
    means = {mark.label: mark for mark in over_speed.panels[-1].marks if mark.label.startswith("mean")}

    def step(mean):
        return mean.y[(mean.x > -3) & (mean.x < -0.5)].mean() - mean.y[(mean.x < 3) & (mean.x > 0.5)].mean()

    assert step(means["mean before"]) > 2.0
    assert abs(step(means["mean after"])) < 0.1


def test_the_effect_runs_through_what_is_missing_without_it(read_content, shown_curves):
    (figure,) = effects_through_residuals(read_content, shown_curves)
    cloud, mean, *_, fitted = figure.panels[0].marks
    assert set(np.sign(fitted.y) * np.sign(fitted.x)) <= {-1.0, 0.0}
    assert np.abs(fitted.y).max() == pytest.approx(
        1e3 * read_content["effects"][0]["parameters"]["torque"]["value"], rel=2e-3
    )
    far = np.abs(mean.x) > 1
    along = np.interp(mean.x, *np.stack([fitted.x, fitted.y])[:, np.argsort(fitted.x)])
    assert mean.y[far] == pytest.approx(along[far], abs=0.1)
    assert len(cloud.x) <= 1500
    assert read_content["effects"][0]["formula"] in figure.caption


def test_an_encoder_s_effect_has_no_torque_to_draw(read_content, shown_curves):
    nothing = replace(shown_curves.after, effects=np.zeros_like(shown_curves.after.effects))
    assert list(effects_through_residuals(read_content, replace(shown_curves, after=nothing))) == []


def test_angles_are_shown_within_a_turn(read_content, shown_curves):
    turned = replace(shown_curves.before, angle=shown_curves.before.angle + 6 * np.pi)
    *_, figure = missing_torques(read_content, replace(shown_curves, before=turned))
    assert all(np.nanmax(np.abs(mark.x)) <= np.pi for panel in figure.panels for mark in panel.marks)


def test_a_few_wild_dots_do_not_squeeze_the_rest(read_content, shown_curves):
    missing = shown_curves.before.missing.copy()
    missing[::200] = 1e3
    wild = replace(shown_curves, before=replace(shown_curves.before, missing=missing))
    over_speed, *_ = missing_torques(read_content, wild)
    low, high = over_speed.panels[-1].y.limits
    assert low == -high
    assert high < 20.0


def test_a_nonparametric_torque_is_drawn_with_its_band(read_content):
    assert list(nonparametric_torques(read_content)) == []
    curve = {"over": "angle", "at": [-1.0, 0.0, 1.0], "torque": [0.0, 0.02, 0.01], "std": [1e-3, 2e-3, 1e-3]}
    curve |= {"coefficients": [0.0], "coefficients_std": [0.0], "likeness": "an unbalance"}
    effect = read_content["effects"][0] | {"curve": curve, "name": "unknown_torque"}
    (figure,) = nonparametric_torques(read_content | {"effects": [effect]})
    torque, band = figure.panels[0].marks
    above, below = band.y[:3], band.y[4:]
    assert torque.y.tolist() == [0.0, 20.0, 10.0]
    assert above - torque.y == pytest.approx(torque.y - below)
    assert above[1] - torque.y[1] == pytest.approx(3.92, abs=0.01)
    assert "like that of an unbalance" in figure.caption
