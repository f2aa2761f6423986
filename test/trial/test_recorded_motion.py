# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cdp_ident.trial.balance import motion_on_grid
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.recorded_motion import at_rest, cart_driven, clean, cut_at_gaps, recorded_motion

MS = 1_000_000
ORIGIN = 10**18

TIME = np.arange(2000) * 0.005


def cleaned(milliseconds, longest_gap=0.1):
    stamps = ORIGIN + np.array(milliseconds, dtype=np.int64) * MS
    number = np.arange(len(stamps), dtype=float)
    pieces, notes = pieces_of(Samples(stamps, np.column_stack([number, number]) * 1e-3, number), longest_gap)
    return [piece.samples.cart.astype(int).tolist() for piece in pieces], [piece.time for piece in pieces], notes


def pieces_of(samples, longest_gap=0.1, **limits):
    of_all, outlying, notes = clean(samples, **limits)
    pieces, gaps = cut_at_gaps(of_all, outlying, longest_gap)
    return pieces, "; ".join([*notes, *gaps])


def test_good_samples_pass_as_they_are():
    pieces, times, notes = cleaned([0, 5, 10, 15])
    assert pieces == [[0, 1, 2, 3]]
    assert np.allclose(times[0], [0, 0.005, 0.01, 0.015])
    assert notes == ""


def test_of_repeated_stamps_the_first_is_kept():
    pieces, _, notes = cleaned([0, 5, 5, 5, 10])
    assert pieces == [[0, 1, 4]]
    assert "2 samples with a stamp that was there already" in notes


def test_a_clock_that_is_set_back_parts_the_recording_and_loses_nothing():
    pieces, times, notes = cleaned([1000, 1005, 1010, *range(500, 540, 5)])
    assert pieces == [[0, 1, 2], list(range(3, 11))]
    assert times[1][0] == pytest.approx(0.01)
    assert "set back by 0.510 s at 0.010 s" in notes


@pytest.mark.parametrize("back", [300, 100_000])
def test_time_is_counted_on_where_the_clock_was_set_back_by_less_or_more_than_has_passed(back):
    stamps = ORIGIN + MS * np.concatenate([np.arange(0, 1000, 5), np.arange(1000, 2000, 5) - back])
    samples = Samples(stamps, np.zeros((len(stamps), 2)), np.arange(len(stamps), dtype=float))
    pieces, _ = pieces_of(samples, start=0.2, stop=1.5)
    assert [tuple(piece.samples.cart[[0, -1]]) for piece in pieces] == [(40, 199), (200, 301)]
    assert pieces[-1].time[-1] == pytest.approx(1.5)


def test_long_gaps_part_the_recording_and_short_ones_are_told():
    pieces, _, notes = cleaned([0, 5, 10, 50, 55, 300, 305])
    assert pieces == [[0, 1, 2, 3, 4], [5, 6]]
    assert "1 gaps of up to 40 ms are kept" in notes
    assert "a gap of 0.245 s at 0.055 s parts the recording" in notes


@given(st.lists(st.integers(0, 10**12), min_size=1, max_size=80))
def test_whatever_the_stamps_times_increase_and_every_sample_is_used_at_most_once(stamps):
    samples = Samples(np.array(stamps), np.zeros((len(stamps), 2)), np.arange(len(stamps), dtype=float))
    pieces, _ = pieces_of(samples)
    used = np.concatenate([piece.samples.cart for piece in pieces])
    assert len(np.unique(used)) == len(used)
    for piece in pieces:
        assert np.all(np.diff(piece.time) > 0)
        assert np.all(np.diff(piece.time) <= 0.1 + 1e-9)
        assert np.allclose(np.diff(piece.time), np.diff(np.array(stamps)[piece.samples.cart.astype(int)]) * 1e-9)


@given(st.integers(0, 199), st.integers(0, 1), st.floats(-30, 30), st.floats(-12, 12))
@example(at=5, joint=0, size=6.4375, speed=12.0)
def test_a_spike_of_any_size_is_left_out_and_adds_no_turn(at, joint, size, speed):
    time = np.arange(200) * 5 * MS
    angles = np.column_stack([speed * np.arange(200) * 0.005, np.sin(np.arange(200) * 0.02)])
    spiked = angles.copy()
    spiked[at, joint] += size
    samples = Samples(ORIGIN + time, spiked, None)
    (piece,), notes = pieces_of(samples)
    rest = np.delete(angles, at, axis=0) if len(piece.time) == 199 else angles
    # At the ends there are neighbours on one side only.
    seen_from = 0.07 if 5 <= at < 195 else 0.3
    assert len(piece.time) == 199 or abs(np.mod(size + np.pi, 2 * np.pi) - np.pi) < seen_from
    assert np.allclose(np.diff(piece.samples.angles, axis=0), np.diff(rest, axis=0), atol=0.3)
    if len(piece.time) == 199 and 0 < at < 199:
        assert clean(samples)[1] == pytest.approx([at * 0.005])
    assert notes == ""


@pytest.mark.parametrize(("zeroed", "by"), [((0,), -3.05), ((1,), np.pi), ((0, 1), -1.2), ((0, 1), 5.0)])
def test_readings_from_another_zero_are_those_from_the_first(zeroed, by):
    count = 2 * np.pi / 8000
    right = np.round(np.column_stack([1.5 * np.sin(5 * TIME), 2 * np.cos(7 * TIME)]) / count) * count
    angles = right.copy()
    angles[900:, zeroed] += np.round(by / count) * count
    angles[1500:, 0] += 40 * count
    found = recorded_motion(Samples(ORIGIN + np.arange(2000) * 5 * MS, angles, None), TrialOptions())
    (piece,) = found.pieces
    right[1500:, 0] += 40 * count
    off = piece.samples.angles - right
    assert np.max(np.abs(off - 2 * np.pi * np.round(off / 2 / np.pi))) < 1.5 * count
    assert sum("at 4.500 s (another zero, a reset?): taken out" in note for note in found.notes) == len(zeroed)
    assert sum("at 7.500 s (lost counts?): kept" in note for note in found.notes) == 1


def motion(angle, cart=None):
    return motion_on_grid(TIME, np.column_stack([angle, np.zeros(len(TIME))]), cart)


def stretch(mask):
    """First and last time of a mask over TIME's grid that is one stretch."""
    spacing = (TIME[-1] - TIME[0]) / len(mask)
    marked = np.flatnonzero(mask)
    assert np.all(np.diff(marked) == 1)
    return marked[0] * spacing, marked[-1] * spacing


def test_rest_is_found_up_to_the_instant_at_which_motion_begins():
    start, end = stretch(at_rest(motion(np.where(TIME > 4, np.sin(3 * (TIME - 4)), 0.0)), 0.01))
    assert start == 0
    assert 3.95 <= end <= 4.1


def test_noise_of_an_encoder_is_rest_and_a_small_swing_is_not():
    noise = np.random.default_rng(2).normal(0, 2e-3, len(TIME))
    assert np.all(at_rest(motion(noise), 0.01))
    assert not np.any(at_rest(motion(0.03 * np.sin(4 * TIME) + noise), 0.01))


def test_a_swing_that_dies_away_is_rest_from_where_it_is_four_times_the_noise():
    noise = np.random.default_rng(2).normal(0, 0.02, len(TIME))
    start, end = stretch(at_rest(motion(np.exp(-0.3 * TIME) * np.sin(4 * TIME) + noise), 0.01))
    assert 5.5 < start < -np.log(np.sqrt(2) * 4 * 0.02) / 0.3
    assert end > TIME[-1] - 0.2


def test_the_turning_points_of_a_slow_swing_are_no_rest():
    assert not np.any(at_rest(motion(np.sin(1.5 * TIME)), 0.01))


def test_a_cart_is_driven_while_it_goes_far_in_a_short_time():
    cart = np.interp(TIME, [0, 5, 5.5, 10], [0, 0.004, 0.1, 0.104])
    start, end = stretch(cart_driven(motion(4 * TIME, cart), 0.01))
    assert 4.5 <= start <= 5.1
    assert 5.4 <= end <= 6.0


def test_a_slightly_compliant_base_is_not_driven():
    assert not np.any(cart_driven(motion(TIME, 0.004 * np.sin(8 * TIME)), 0.01))
