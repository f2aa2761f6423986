# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import TrialError
from cdp_ident.trial.film import rods_on_film

TIME = np.arange(600) * 0.01
THETA = np.column_stack([np.pi + 2 * np.sin(5 * TIME), np.pi + 2.5 * np.cos(7 * TIME)])


def markers(theta=THETA, length=200.0, tip=180.0, noise=0.3, pivot=(640.0, 360.0), seed=1):
    """Positions (n, 3, 2) of pivot, joint and tip in a picture whose y counts down."""
    rods = np.stack([np.sin(theta), -np.cos(theta)], axis=-1) * [[length], [tip]]
    points = np.stack([np.zeros_like(rods[:, 0]), rods[:, 0], rods.sum(axis=1)], axis=1)
    return points + pivot + np.random.default_rng(seed).normal(0, noise, points.shape)


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


def test_a_camera_that_looks_from_the_side_is_put_right_but_for_its_lean():
    turn = np.array([[np.cos(0.6), np.sin(0.6)], [-np.sin(0.6), np.cos(0.6)]])
    film = rods_on_film(markers() @ turn * (0.94, 1.0) @ turn.T, y_down=True)
    off = np.angle(np.exp(1j * (film.angles - THETA[film.kept])))
    assert np.std(off, axis=0) == pytest.approx([0.0, 0.0], abs=5e-3)


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
    points[-50:] = points[-50]
    film = rods_on_film(points, y_down=True)
    assert np.flatnonzero(~film.kept).tolist() == [100, 201, 202]
    assert "3 frames repeat the one before" in film.notes[0]
    moving = film.kept[:550]
    assert np.abs(np.angle(np.exp(1j * (film.angles[: moving.sum()] - THETA[:550][moving])))).max() < 0.01


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
