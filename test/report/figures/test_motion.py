# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Angles over time: what is shown, and where it was held out."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.report.curves import NO_WINDOW
from cdp_ident.report.figures import motion
from cdp_ident.report.figures.motion import angles, continuous_runs, file_name, shown_samples


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
    monkeypatch.setattr(motion, "MOST_SAMPLES", 2500)
    assert shown_samples(shown_curves).step == 3
    figure = next(angles(read_content, shown_curves))
    assert len(figure.panels[0].marks[0].x) == pytest.approx(len(shown_curves.trials[0].time) / 3, abs=1)
    assert "One of 3 samples is shown" in figure.caption


@pytest.mark.parametrize("name", ["../../etc/passwd", "a b/c", '"><img src=x>', "x" * 500, "日本", ""])
def test_a_trial_s_name_cannot_lead_a_file_elsewhere(name):
    safe = file_name(name)
    assert len(safe) <= 40
    assert not set(safe) - set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-")
