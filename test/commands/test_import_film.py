# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Markers on a film become a bag in the project's conventions."""

import numpy as np
import pytest

from cdp_ident.trial.load import load_trial
from scenarios.tables import swing

MARKERS = "frame,pivot_x,pivot_y,joint_x,joint_y,tip_x,tip_y"


def film(length, rate, seconds, noise=0.3, lean=0.0, lost=0.0, exchanged=0.0, pixels=200.0):
    """Frame numbers and marker positions in pixels (n, 7), y down; angles have noise of about noise / pixels."""
    generator = np.random.default_rng(3)
    time, theta = swing(length, rate, seconds)
    rods = np.stack([np.sin(theta - lean), -np.cos(theta - lean)], axis=-1) * [[pixels], [0.9 * pixels]]
    points = np.stack([np.zeros_like(rods[:, 0]), rods[:, 0], rods.sum(axis=1)], axis=1) + np.array([640, 360])
    points += generator.normal(0, noise, points.shape)
    swapped = generator.random(len(time)) < exchanged
    points[swapped, 1:] = points[swapped, :0:-1]
    kept = generator.random(len(time)) >= lost
    return theta[kept], np.column_stack([np.arange(len(time)), points.reshape(len(time), 6)])[kept]


@pytest.mark.parametrize(
    ("length", "rate", "seconds", "lost"), [(0.09, 500.0, 8.0, 0.0), (0.17, 100.0, 6.0, 0.1), (1.0, 60.0, 15.0, 0.05)]
)
def test_a_film_becomes_a_trial_whose_length_agrees(convert, capsys, tmp_path, length, rate, seconds, lost):
    theta, rows = film(length, rate, seconds, lean=0.01, lost=lost, exchanged=0.05)
    convert([rows], "--rate", f"{rate:g}", "--length", f"{length:g}", title=MARKERS, digits=3)
    said = capsys.readouterr().out
    assert "warning" not in said
    assert "joint and tip are exchanged in" in said
    assert "lean" not in said
    trial = load_trial(tmp_path / "bag")
    assert len(trial.time) >= len(theta) - 3
    assert np.abs(np.angle(np.exp(1j * (trial.theta + 0.01 - theta[-len(trial.time) :])))).max() < 0.02


def test_frames_that_were_written_twice_change_neither_values_nor_how_sure_they_are(convert, capsys):
    theta, rows = film(0.17, 100.0, 6.0, noise=0.1)
    twice = np.random.default_rng(4).random(len(rows)) < 0.36
    again = np.maximum.accumulate(np.where(twice, 0, np.arange(len(rows))))
    rows[:, 1:] = rows[again, 1:]
    positions, stamps, _ = convert([rows], "--rate", "100", "--length", "0.17", title=MARKERS, digits=3)
    assert "frames repeat the one before and are left out" in capsys.readouterr().out
    frames = np.round((stamps - stamps[0]) * 1e-7).astype(int) + int(rows[0, 0])
    assert np.abs(np.angle(np.exp(1j * (positions.cumsum(axis=1) - theta[frames])))).max() < 0.01


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("share", "rate"), [(0.36, 60.0), (0.5, 120.0)])
def test_a_film_that_repeats_many_frames_is_a_double_pendulum_s(convert, tmp_path, share, rate, seed):
    theta, rows = film(0.4, rate, 13.0, pixels=360.0)
    again = np.random.default_rng(seed).random(len(rows)) < share
    rows[:, 1:] = rows[np.maximum.accumulate(np.where(again, 0, np.arange(len(rows)))), 1:]
    convert([rows], "--rate", f"{rate:g}", "--length", "0.4", title=MARKERS, digits=3)
    trial = load_trial(tmp_path / "bag")
    assert trial.duration > 11.0
    frames = np.round((trial.time + trial.start) * rate).astype(int)
    off = np.abs(np.angle(np.exp(1j * (trial.theta - theta[frames]))))
    assert np.quantile(off, 0.99) < 0.005


def test_a_film_s_rate_is_checked_against_the_motion(convert, capsys):
    _, rows = film(0.09, 500.0, 8.0)
    convert([rows], "--rate", "120", "--length", "0.09", title=MARKERS, digits=3)
    assert "with --rate 50" in capsys.readouterr().out or "with --rate 49" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("lean", "options", "message"),
    [
        (0.0, ["--y-axis", "up"], "gravity pulls up in the picture"),
        (0.35, [], "about 20 degrees from the picture's vertical"),
        (np.pi / 2, [], "about 90 degrees from the picture's vertical"),
        (0.0, ["--zero", "hanging"], "--zero does not go with points"),
    ],
)
def test_gravity_s_direction_on_a_film_is_checked_against_the_motion(refuse, lean, options, message):
    _, rows = film(0.4, 100.0, 8.0, lean=lean, noise=0.05)
    assert message in refuse([rows], "--rate", "100", *options, title=MARKERS)


def test_points_may_be_named_and_be_in_metres(convert):
    theta, rows = film(0.4, 100.0, 8.0, noise=0.02)
    metres = rows[:, 1:] * ([1e-3, -1e-3] * 3)
    names = ["--points", "a", "b", "c", "d", "e", "f", "--points-unit", "m"]
    positions, _, _ = convert([rows[:, 0] / 100, metres], *names, title="t,a,b,c,d,e,f")
    assert np.abs(np.angle(np.exp(1j * (positions.cumsum(axis=1) - theta)))).max() < 0.01
