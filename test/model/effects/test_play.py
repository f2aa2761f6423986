"""An encoder with play follows its joint as described independently, and goes on from piece to piece."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.model.effects.play import Turned, follow
from reference import hidden_effects
from reference.pendulum import TABLE_5

TIME = np.arange(600) / 200.0
SWING = np.sin(3.0 * TIME) + 0.4 * np.sin(7.3 * TIME + 1.0)


def described(angle, gap):
    """Return what an independent description says that the encoder shows, which begins in the middle of the gap."""
    states = np.stack([angle + np.pi, angle, angle, angle], axis=1)
    added = hidden_effects.backlash("inner").reading(TIME[: len(angle)], lambda times: states, TABLE_5, 0.5 * gap)
    return angle + added[:, 0]


@given(
    st.lists(st.floats(-0.1, 0.1), min_size=1, max_size=50).map(np.cumsum),
    st.one_of(st.just(0.0), st.floats(1e-6, 0.2)),
)
def test_an_encoder_follows_its_joint_as_described_independently(angle, gap):
    assert follow(angle, gap, angle[0]).angle == pytest.approx(described(angle, gap), abs=1e-12)


@pytest.mark.parametrize("gap", [0.0, 0.02, 0.3])
def test_it_is_somewhere_in_the_gap_and_stays_where_it_is_until_it_is_pushed(gap):
    followed = follow(SWING, gap)
    assert np.abs(followed.angle - SWING).max() <= 0.5 * gap + 1e-12
    pushed = followed.source == np.arange(len(SWING))
    assert np.all(np.diff(followed.angle)[~pushed[1:]] == 0.0)
    if gap:
        assert 0.05 < np.mean(~pushed) < 0.7


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_joint_that_turns_pushes_its_encoder_from_the_beginning(direction):
    angle = direction * np.linspace(0.0, 1.0, 10)
    followed = follow(angle, 0.1)
    assert followed.angle == pytest.approx(angle - direction * 0.05)
    assert followed.by_gap == pytest.approx(-0.5 * direction)


def test_an_encoder_whose_joint_rests_shows_the_middle_of_the_gap():
    assert np.all(follow(np.full(5, 0.3), 0.1).angle == 0.3)


def test_its_derivatives_are_those_of_the_instant_at_which_it_was_pushed_last():
    directions = np.stack([np.cos(TIME), np.sin(2.0 * TIME)], axis=1)
    followed = follow(SWING, 0.3, 0.4)
    assert np.any(followed.source < 0)
    step = 1e-7
    for k in range(2):
        sides = (follow(SWING + sign * step * directions[:, k], 0.3, 0.4).angle for sign in (1.0, -1.0))
        differences = np.subtract(*sides) / (2.0 * step)
        assert followed.slopes(directions)[:, k] == pytest.approx(differences, abs=1e-5)
    wider, narrower = (follow(SWING, 0.3 + sign * step, 0.4).angle for sign in (1.0, -1.0))
    assert followed.by_gap == pytest.approx((wider - narrower) / (2.0 * step), abs=1e-5)


def test_at_no_gap_the_derivative_by_it_is_against_the_motion():
    followed = follow(SWING, 0.0)
    assert np.array_equal(followed.angle, SWING)
    assert followed.by_gap[1:] == pytest.approx(-0.5 * np.sign(np.diff(SWING)))


@given(st.lists(st.integers(1, len(TIME) - 1), max_size=20), st.integers(0, 5))
def test_piece_by_piece_it_is_turned_as_at_once(cuts, overlap):
    bounds = [0, *sorted(set(cuts)), len(TIME)]
    turned, pieces = Turned(), []
    for first, last in pairwise(bounds):
        begin = max(first - min(overlap, first), bounds[max(bounds.index(first) - 1, 0)])
        piece = turned.follow(0, TIME[begin:last], SWING[begin:last], 0.2, 0.5)
        pieces.append(piece.angle[first - begin :])
    assert np.concatenate(pieces) == pytest.approx(follow(SWING, 0.2, 0.5).angle, abs=1e-12)


def test_a_motion_that_is_lost_is_not_shown():
    angle = SWING.copy()
    angle[400:] = np.nan
    followed = follow(angle, 0.1)
    assert np.all(np.isfinite(followed.angle[:400]))
    assert np.all(np.isnan(followed.angle[400:]))
    assert np.all(np.isnan(followed.slopes(angle[:, None])[400:]))
