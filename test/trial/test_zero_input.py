# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from cdp_ident.errors import TrialError
from cdp_ident.trial.balance import motion_on_grid
from cdp_ident.trial.zero_input import CART, FREE, HAND, REST, Part, at_rest, cart_driven, choose_parts

TIME = np.arange(2000) * 0.005


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


def test_the_longest_free_part_is_taken_and_everything_else_told():
    parts = [Part(0, HAND, 0, 2), Part(0, FREE, 2, 7), Part(0, CART, 7, 8), Part(1, FREE, 9, 20), Part(1, REST, 20, 30)]
    taken, notes = choose_parts(parts, 2.0)
    assert taken == [parts[3]]
    assert notes == [
        "cut 0.00 to 2.00 s (a hand is at the rods)",
        "cut 7.00 to 8.00 s (the cart is driven)",
        "cut 20.00 to 30.00 s (the rods are still)",
        "another zero-input part from 2.00 to 7.00 s is not used: another is longer",
    ]


def test_too_short_a_part_is_an_error_that_says_what_fills_the_rest():
    with pytest.raises(TrialError, match=r"the longest has 1\.00 s \(1\.00 to 9\.00 s \(the rods are still\)\)"):
        choose_parts([Part(0, FREE, 0, 1), Part(0, REST, 1, 9)], 2.0)


def test_free_parts_with_nothing_but_a_gap_between_them_are_one_motion():
    parts = [Part(0, FREE, 0, 3), Part(1, FREE, 3.1, 5), Part(1, REST, 5, 6), Part(2, FREE, 6.1, 10)]
    taken, notes = choose_parts(parts, 1.0)
    assert taken == parts[:2]
    assert notes[-1] == "another zero-input part from 6.10 to 10.00 s is not used: another is longer"


@pytest.mark.parametrize("begin", [2.5, 5.5])
def test_a_clock_set_back_or_a_gap_of_a_swing_parts_them(begin):
    parts = [Part(0, FREE, 0, 3), Part(1, FREE, begin, begin + 5)]
    assert choose_parts(parts, 1.0)[0] == parts[1:]
