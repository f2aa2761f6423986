# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import TrialError
from cdp_ident.trial.film import rods_on_film, without_offsets

TIME = np.arange(600) * 0.01
THETA = np.column_stack([np.pi + 2 * np.sin(5 * TIME), np.pi + 2.5 * np.cos(7 * TIME)])
LONG_TIME = np.arange(3000) * 0.005
LONG = np.column_stack([np.pi + 2 * np.sin(5 * LONG_TIME), np.pi + 2.5 * np.cos(7 * LONG_TIME) + LONG_TIME])
"""As long as it takes to see where markers are off."""


def in_plane(theta, tip=180.0, noise=0.3, seed=1, pivot=(0.0, 0.0), joint=(0.0, 0.0), at_tip=(0.0, 0.0)):
    """Positions (n, 3, 2) of markers at pivot, joint and tip that are off, y counting up.

    The pivot's and the tip's offsets are fixed in the picture, the joint's is along and across the inner rod.
    """
    directions = np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    rods = directions * [[200.0], [tip]]
    across = directions[:, 0, ::-1] * [1.0, -1.0]
    points = np.stack([np.zeros_like(rods[:, 0]), rods[:, 0], rods.sum(axis=1)], axis=1)
    points[:, 1] += joint[0] * directions[:, 0] + joint[1] * across
    points[:, 0], points[:, 2] = points[:, 0] + pivot, points[:, 2] + at_tip
    return points + np.random.default_rng(seed).normal(0, noise, points.shape)


def markers(theta=THETA, **options):
    """Positions (n, 3, 2) of pivot, joint and tip in a picture whose y counts down."""
    return in_plane(theta, **options) * [1.0, -1.0] + (640.0, 360.0)


def error(film):
    return np.abs(np.angle(np.exp(1j * (film.angles - THETA[film.kept])))).max()


def test_positions_in_pixels_become_angles():
    film = rods_on_film(markers(), y_down=True)
    assert error(film) < 0.01
    assert film.length == pytest.approx(200, rel=1e-3)
    assert film.pivot is None
    assert film.notes == ()


@pytest.mark.parametrize(("wide", "high"), [(1.0, 4 / 3), (1.09, 1.0), (1.0, 1.02)])
def test_pixels_that_are_not_square_are_put_right(wide, high):
    film = rods_on_film(markers() * (wide, high), y_down=True)
    assert error(film) < 0.012
    assert float(film.notes[0].split()[3]) == pytest.approx(max(wide, high), rel=0.01)


@pytest.mark.parametrize(("wide", "high"), [(1.0, 4 / 3), (1.09, 1.0), (1.0, 1.09), (4 / 3, 1.0)])
@pytest.mark.parametrize("inner", [0.9, 1.2])
def test_a_stretch_is_put_right_before_joint_and_tip_are_told_apart(wide, high, inner):
    theta = np.column_stack([np.pi + inner * np.sin(5 * TIME), np.pi + 2.2 * np.cos(7 * TIME)])
    theta[:, 1] += theta[:, 0] - np.pi
    film = rods_on_film(markers(theta) * (wide, high), y_down=True)
    assert np.count_nonzero(film.kept) == len(TIME)
    assert np.abs(np.angle(np.exp(1j * (film.angles - theta)))).max() < 0.02
    assert float(film.notes[0].split()[3]) == pytest.approx(max(wide, high), rel=0.01)


def test_a_camera_that_looks_from_the_side_is_put_right_but_for_its_lean():
    turn = np.array([[np.cos(0.6), np.sin(0.6)], [-np.sin(0.6), np.cos(0.6)]])
    film = rods_on_film(markers() @ turn * (0.94, 1.0) @ turn.T, y_down=True)
    off = np.angle(np.exp(1j * (film.angles - THETA[film.kept])))
    assert np.std(off, axis=0) == pytest.approx([0.0, 0.0], abs=5e-3)


@pytest.mark.parametrize("distorts", [0.02, -0.03, -0.2])
@pytest.mark.parametrize("off", [{}, {"pivot": (2.0, -1.0), "joint": (1.0, 1.0)}], ids=["", "markers off"])
def test_a_lens_that_distorts_is_put_right_wherever_the_picture_s_centre_is(distorts, off):
    plain = in_plane(LONG, noise=0.0, **off) * [1.0, -1.0] + (600.0, 290.0)
    away = plain - (640.0, 360.0)
    seen = plain + distorts * np.sum(away**2, axis=-1, keepdims=True) / (640.0**2 + 360.0**2) * away
    film = rods_on_film(seen + np.random.default_rng(2).normal(0, 0.3, seen.shape), y_down=True)
    left = np.angle(np.exp(1j * (film.angles - LONG[film.kept])))
    assert np.all(np.std(left, axis=0) < [3.1e-3, 3.2e-3])  # 1.5 and 2.3 mrad of it are the markers' noise
    assert any("a lens distorts the picture" in note for note in film.notes)


@pytest.mark.parametrize("noise", [0.1, 0.3, 1.0])
def test_the_markers_noise_is_no_lens_however_little_the_elbow_bends(noise):
    bends = LONG[:, 0] + 0.5 * np.sin(7 * LONG_TIME)
    film = rods_on_film(markers(np.column_stack([LONG[:, 0], bends]), noise=noise), y_down=True)
    assert film.notes == ()


def test_positions_in_metres_have_y_upwards():
    assert error(rods_on_film(markers() * (1e-3, -1e-3), y_down=False)) < 0.01


@given(
    exchanged=st.floats(0, 0.4),
    lost=st.floats(0, 0.3),
    tip=st.sampled_from([90.0, 180.0, 240.0]),
    seed=st.integers(0, 99),
)
def test_markers_that_are_exchanged_or_lost_do_no_harm(exchanged, lost, tip, seed):
    generator = np.random.default_rng(seed)
    points = markers(tip=tip, seed=seed)
    swapped = generator.random(len(points)) < exchanged
    points[swapped, 1:] = points[swapped, :0:-1]
    gone = generator.random(len(points)) < lost
    points[gone] = np.where(generator.random((np.count_nonzero(gone), 1, 1)) < 0.5, np.nan, 0.0)
    film = rods_on_film(points, y_down=True)
    assert np.array_equal(film.kept, ~gone)
    assert error(film) < 0.03


def test_what_was_mended_is_told():
    points = markers()
    points[10:15, 1:] = points[10:15, :0:-1]
    points[20] = np.nan
    points[30, 1:] = 0
    assert rods_on_film(points, y_down=True).notes == (
        "1 frames lack a marker and are left out",
        "joint and tip are exchanged in 5 frames: put right",
        "in 1 frames the joint is not where it can be: left out",
    )


def test_frames_that_repeat_the_one_before_are_left_out_but_not_rods_at_rest():
    points = markers()
    points[100] = points[99]
    points[201:203] = points[200]
    points[301:316] = points[300]
    points[-50:] = points[-50]
    film = rods_on_film(points, y_down=True)
    assert np.flatnonzero(~film.kept).tolist() == [100, 201, 202, *range(301, 316)]
    assert "18 frames repeat the one before" in film.notes[0]
    moving = film.kept[:550]
    assert np.abs(np.angle(np.exp(1j * (film.angles[: moving.sum()] - THETA[:550][moving])))).max() < 0.01


@pytest.mark.parametrize("off", [0.002, 0.1])
def test_frames_that_nearly_repeat_the_one_before_in_motion_are_left_out(off):
    again = np.random.default_rng(3).random(len(THETA)) < 0.3
    again[0] = False
    shown = np.maximum.accumulate(np.where(again, 0, np.arange(len(THETA))))
    points = markers()[shown] + np.random.default_rng(4).normal(0, off, (len(THETA), 3, 2))
    film = rods_on_film(points, y_down=True)
    assert np.mean(film.kept == again) < 0.01
    assert "frames repeat the one before" in film.notes[0]


def test_rods_at_rest_whose_markers_in_whole_pixels_repeat_now_and_then_stay():
    points = np.round(markers(np.concatenate([np.repeat(THETA[:1], 200, axis=0), THETA])))
    points[400] = points[399]
    film = rods_on_film(points, y_down=True)
    assert np.count_nonzero(np.all(points[1:200] == points[:199], axis=(1, 2))) > 5
    assert np.flatnonzero(~film.kept).tolist() == [400]


def test_without_the_pivot_it_is_the_centre_of_the_joint_s_circle():
    film = rods_on_film(markers()[:, 1:], y_down=True)
    assert error(film) < 0.01
    assert film.notes[0].startswith("the pivot is the centre of the joint's circle, x 640")


def test_a_pivot_on_a_cart_is_followed():
    cart = 60 * np.sin(3 * TIME)
    film = rods_on_film(markers() + np.column_stack([cart, 0 * cart])[:, None], y_down=True)
    assert error(film) < 0.02
    assert film.pivot == pytest.approx(640 + cart, abs=2)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (markers()[:, [1, 0, 2]], "the pivot moves up and down"),
        (np.full((50, 3, 2), np.nan), "no frame has numbers"),
        (np.zeros((50, 3, 2)), "the same point"),
        (np.random.default_rng(1).uniform(0, 500, (300, 3, 2)), "in many frames"),
        (
            markers() * 0 + np.random.default_rng(1).uniform(0, 500, (600, 3, 2)) * [[[0], [1], [1]]],
            "more or less in many frames",
        ),
    ],
)
def test_what_is_no_pendulum_is_refused(points, message):
    with pytest.raises(TrialError, match=message):
        rods_on_film(points, y_down=True)


def errors(rods):
    return np.angle(np.exp(1j * (np.arctan2(rods[:, :, 0], rods[:, :, 1]) - LONG)))


@pytest.mark.parametrize(
    ("marker", "offset", "words"),
    [
        ("pivot", (1.5, -1.0), "the pivot's marker is 1.8 off the centre of the joint's circle: put right"),
        ("at_tip", (-0.5, 1.5), "the tip's marker is seen 1.6 beside where it is: put right"),
        ("joint", (1.0, -1.2), "the joint's marker is 1.6 off the joint: put right"),
    ],
)
def test_a_marker_that_is_off_no_longer_turns_the_angles(marker, offset, words):
    points = in_plane(LONG, **{marker: offset})
    rods, notes = without_offsets(points)
    assert notes == (words,)
    as_seen = np.abs(errors(np.diff(points, axis=1))).max(axis=1).mean()
    assert as_seen > 2.0 * np.abs(errors(rods)).max(axis=1).mean()
    assert np.abs(errors(rods).mean(axis=0)).max() < 1e-3


def test_all_three_are_told_apart():
    rods, notes = without_offsets(in_plane(LONG, pivot=(1.0, 0.5), joint=(-0.8, 0.9), at_tip=(0.7, 1.0)))
    assert len(notes) == 3
    assert errors(rods).std() < 1.2 * errors(np.diff(in_plane(LONG), axis=1)).std()


@given(noise=st.floats(0.01, 2.0), seed=st.integers(0, 200))
def test_markers_that_are_right_stay_as_they_are(noise, seed):
    points = in_plane(LONG, noise=noise, seed=seed)
    rods, notes = without_offsets(points)
    assert notes == ()
    np.testing.assert_array_equal(rods, np.diff(points, axis=1))


def test_a_little_swing_tells_nothing_of_offsets_and_a_lens_over_a_short_arc_is_none():
    swing = np.column_stack([np.sin(5 * LONG_TIME), np.cos(7 * LONG_TIME)])
    half = np.pi + 0.8 * swing
    little, lens = in_plane(np.pi + 0.05 * swing, pivot=(1.0, 1.0), noise=0.5), in_plane(half)
    lens[:, 1:] *= 1.0 + 0.01 * half[:, :, None] ** 2 / np.pi**2
    for points in (little, lens):
        rods, notes = without_offsets(points)
        assert notes == ()
        np.testing.assert_array_equal(rods, np.diff(points, axis=1))


def test_frames_in_which_a_marker_was_not_where_it_is_do_not_count():
    points = in_plane(LONG, joint=(1.0, -1.2))
    points[::50, 2] += 40.0
    for notes in (without_offsets(points)[1], rods_on_film(points, y_down=False).notes):
        assert notes == ("the joint's marker is 1.6 off the joint: put right",)
