# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.trial.film import rods_on_film, without_offsets

TIME = np.arange(3000) * 0.005
THETA = np.column_stack([np.pi + 2 * np.sin(5 * TIME), np.pi + 2.5 * np.cos(7 * TIME) + TIME])
LENGTHS = (200.0, 180.0)


def markers(theta=THETA, pivot=(0.0, 0.0), joint=(0.0, 0.0), tip=(0.0, 0.0), noise=0.3, seed=1):
    """Positions (n, 3, 2) of markers that are off, y counting up.

    The pivot's and the tip's offsets are fixed in the picture, the joint's is along and across the inner rod.
    """
    directions = np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    rods = directions * np.array(LENGTHS)[:, None]
    at_joint, along = rods[:, 0], directions[:, 0]
    across = np.column_stack([along[:, 1], -along[:, 0]])
    points = np.stack(
        [
            np.broadcast_to(pivot, at_joint.shape),
            at_joint + joint[0] * along + joint[1] * across,
            at_joint + rods[:, 1] + tip,
        ],
        axis=1,
    )
    return points + np.random.default_rng(seed).normal(0, noise, points.shape)


def errors(rods, theta=THETA):
    angles = np.arctan2(rods[:, :, 0], rods[:, :, 1])
    return np.angle(np.exp(1j * (angles - theta)))


@pytest.mark.parametrize(
    ("marker", "offset", "words"),
    [
        ("pivot", (1.5, -1.0), "the pivot's marker is 1.8 off the centre of the joint's circle: put right"),
        ("tip", (-0.5, 1.5), "the tip's marker is seen 1.6 beside where it is: put right"),
        ("joint", (1.0, -1.2), "the joint's marker is 1.6 off the joint: put right"),
    ],
)
def test_a_marker_that_is_off_no_longer_turns_the_angles(marker, offset, words):
    points = markers(**{marker: offset})
    rods, notes = without_offsets(points)
    assert notes == (words,)
    as_seen = np.abs(errors(np.diff(points, axis=1))).max(axis=1).mean()
    assert as_seen > 2.0 * np.abs(errors(rods)).max(axis=1).mean()
    assert np.abs(errors(rods).mean(axis=0)).max() < 1e-3


def test_all_three_are_told_apart():
    rods, notes = without_offsets(markers(pivot=(1.0, 0.5), joint=(-0.8, 0.9), tip=(0.7, 1.0)))
    assert len(notes) == 3
    assert errors(rods).std() < 1.2 * errors(np.diff(markers(), axis=1)).std()


@given(noise=st.floats(0.01, 2.0), seed=st.integers(0, 200))
def test_markers_that_are_right_stay_as_they_are(noise, seed):
    points = markers(noise=noise, seed=seed)
    rods, notes = without_offsets(points)
    assert notes == ()
    np.testing.assert_array_equal(rods, np.diff(points, axis=1))


def test_a_little_swing_tells_nothing_of_offsets():
    little = np.pi + 0.05 * np.column_stack([np.sin(5 * TIME), np.cos(7 * TIME)])
    points = markers(little, pivot=(1.0, 1.0), noise=0.5)
    rods, notes = without_offsets(points)
    assert notes == ()
    np.testing.assert_array_equal(rods, np.diff(points, axis=1))


def test_a_lens_over_a_short_arc_is_no_offset():
    half = np.pi + 0.8 * np.column_stack([np.sin(5 * TIME), np.cos(7 * TIME)])
    points = markers(half)
    points[:, 1:] *= 1.0 + 0.01 * half[:, :, None] ** 2 / np.pi**2
    _, notes = without_offsets(points)
    assert notes == ()


def test_frames_in_which_a_marker_was_not_where_it_is_do_not_count():
    points = markers(joint=(1.0, -1.2))
    points[::50, 2] += 40.0
    _, notes = without_offsets(points)
    assert notes == ("the joint's marker is 1.6 off the joint: put right",)


def test_an_import_says_what_was_put_right():
    film = rods_on_film(markers(joint=(1.0, -1.2)), y_down=False)
    assert film.notes == ("the joint's marker is 1.6 off the joint: put right",)
