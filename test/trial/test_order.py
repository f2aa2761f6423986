"""Samples are used in the order of their stamps, and a clock that is set back is told from samples stored late."""

import numpy as np
import pytest

from cdp_ident.trial.order import elapsed, in_order


def ordered(stamps):
    order, notes = in_order(np.array(stamps, dtype=np.int64) * 1_000_000)
    return order.tolist(), "; ".join(notes)


def test_a_late_sample_is_put_where_its_stamp_belongs():
    assert ordered([0, 5, 10, 7, 15]) == (
        [0, 1, 3, 2, 4],
        "1 samples that were stored late are put where their stamps belong",
    )


def test_blocks_stored_after_later_ones_are_put_where_their_stamps_belong():
    stamps = np.arange(0, 1000, 5)
    stored = np.concatenate([stamps[:60], stamps[100:160], stamps[60:100], stamps[160:]])
    order, notes = ordered(stored)
    assert np.array_equal(stored[order], stamps)
    assert "40 samples that were stored late" in notes


def test_what_was_stored_last_first_is_turned_round():
    stamps = np.arange(0, 1000, 5)
    stored = np.concatenate([stamps[100:], stamps[:100]])
    assert np.array_equal(stored[ordered(stored)[0]], stamps)


def test_samples_stored_in_no_order_are_sorted():
    stamps = np.arange(0, 5000, 5)
    stored = np.random.default_rng(1).permutation(stamps)
    assert np.array_equal(stored[ordered(stored)[0]], stamps)


@pytest.mark.parametrize("back", [300, 100_000])
def test_a_clock_that_is_set_back_leaves_the_order_as_it_is(back):
    stamps = np.concatenate([np.arange(0, 1000, 5), np.arange(1000, 2000, 5) - back])
    assert ordered(stamps) == (list(range(400)), "")
    assert np.all(np.diff(elapsed(stamps)) >= 0)


def test_a_stamp_far_too_early_is_dropped_and_counted():
    order, notes = ordered([1000, 1005, 1010, 20, 1015, 1020])
    assert order == [0, 1, 2, 4, 5]
    assert "1 samples with stamps far from those before and after them are dropped" in notes
