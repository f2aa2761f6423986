# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Samples are used in the order of their stamps, and a clock that is set back is told from samples stored late."""

import re

import numpy as np
import pytest

from cdp_ident.trial.order import counted_on, elapsed, in_order, recorded_again, without_jitter


def ordered(stamps):
    order, notes = in_order(np.array(stamps, dtype=np.int64) * 1_000_000)
    return order.tolist(), "; ".join(notes)


def test_a_late_sample_is_put_where_its_stamp_belongs():
    assert ordered([0, 5, 10, 7, 15]) == (
        [0, 1, 3, 2, 4],
        "1 samples that were stored late are put where their stamps belong",
    )


STAMPS = np.arange(0, 5000, 5)


def late_by(share, time):
    return STAMPS[np.argsort(STAMPS + time * (np.random.default_rng(1).random(1000) < share), kind="stable")]


@pytest.mark.parametrize(
    "stored",
    [
        np.concatenate([STAMPS[:60], STAMPS[100:160], STAMPS[60:100], STAMPS[160:]]),
        np.concatenate([STAMPS[100:], STAMPS[:100]]),
        np.random.default_rng(1).permutation(STAMPS),
        np.random.default_rng(1).permutation(np.arange(0, 13_000, 5).reshape(26, 100)).ravel(),
        *(5 * np.argsort(np.arange(2600) + np.random.default_rng(k).uniform(0, 40, 2600)) for k in range(4)),
        *(late_by(*of) for of in ((0.02, 400), (0.1, 60), (0.3, 30), (0.1, 1500))),
    ],
    ids=["a block late", "the last first", "no order", "blocks in no order", *("near",) * 4, *("some late",) * 4],
)
def test_samples_stored_in_any_order_are_put_in_that_of_their_stamps(stored):
    order, notes = ordered(stored)
    assert np.array_equal(stored[order], np.sort(stored))
    late = re.search(r"(\d+) samples that were stored late", notes)
    assert int(late[1]) == np.count_nonzero(stored < np.maximum.accumulate(stored))


@pytest.mark.parametrize("deviation", [1.5, 2.0, 4.0])
@pytest.mark.parametrize("back", [0, 3600])
def test_stamps_that_step_back_within_their_jitter_are_put_in_order_and_their_samples_stay(deviation, back):
    true = 5_000_000 * np.arange(2000) - 10**9 * back * (np.arange(2000) >= 1000)
    stamps = true + (1e6 * deviation * np.random.default_rng(1).normal(size=2000)).astype(np.int64)
    ascending, note = without_jitter(stamps, np.zeros(2000))
    assert np.flatnonzero(np.diff(ascending) < 0).tolist() == ([999] if back else [])
    assert np.std(ascending - true) < 1e6 * deviation
    stepping, said = re.match(r"(\d+) stamps step back within their jitter of ([\d.]+) ms", note).groups()
    assert int(stepping) == np.count_nonzero(np.diff(stamps) < 0) - (back > 0)
    assert float(said) == pytest.approx(deviation, rel=0.1)


@pytest.mark.parametrize("jitter", [0.0, 0.3])
@pytest.mark.parametrize("apart", [2, 6, 40])
def test_stamps_of_samples_stored_in_another_order_are_not_taken_to_jitter(apart, jitter):
    generator = np.random.default_rng(1)
    stamps = (1e6 * (5 * np.arange(2000) + jitter * generator.normal(size=2000))).astype(np.int64)
    stored = stamps[np.argsort(np.arange(2000) + generator.uniform(0, apart, 2000))]
    ascending, note = without_jitter(stored, np.zeros(2000))
    assert not note
    assert np.array_equal(ascending, stored)


def test_what_is_stored_backwards_is_put_in_order():
    generator = np.random.default_rng(1)
    stamps = np.sort((1e6 * (5 * np.arange(2000) + 0.3 * generator.normal(size=2000))).astype(np.int64))
    assert without_jitter(stamps[::-1], np.zeros(2000))[1] == ""
    assert in_order(stamps[::-1])[0].tolist() == list(range(1999, -1, -1))


@pytest.mark.parametrize("back", [300, 100_000])
def test_a_clock_that_is_set_back_leaves_the_order_as_it_is(back):
    stamps = np.concatenate([np.arange(0, 1000, 5), np.arange(1000, 2000, 5) - back])
    assert ordered(stamps) == (list(range(400)), "")
    assert np.all(np.diff(elapsed(stamps)) >= 0)


def test_a_stamp_far_too_early_is_dropped_and_counted():
    order, notes = ordered([1000, 1005, 1010, 20, 1015, 1020])
    assert order == [0, 1, 2, 4, 5]
    assert "1 samples with stamps far from those before and after them are dropped" in notes


def test_one_stamp_far_in_the_future_does_not_cost_what_follows():
    assert ordered([0, 5, 3_600_000, *range(10, 100, 5)])[0] == [0, 1, *range(3, 21), 2]


@pytest.mark.parametrize(
    ("turn", "what"),
    [
        (2.0**8 * 1e-3, "a counter of 8 bits"),
        (2.0**16 * 1e-6, "a counter of 16 bits"),
        (2.0**24 * 1e-6, "a counter of 24 bits"),
        (2.0**32 * 1e-6, "a counter of 32 bits"),
        (60.0, "seconds of a minute"),
        (86400.0, "a time of day"),
    ],
)
@pytest.mark.parametrize("unit", [1.0, 1e3, 1e9])
@pytest.mark.parametrize("signed", [False, True])
def test_a_counter_that_rolls_over_is_counted_on_in_any_unit(turn, what, unit, signed):
    time = np.arange(2600) * 0.005
    rolling = np.mod(time + (turn / 2 if signed else turn) - 6.5, turn)
    counted, said = counted_on(unit * (np.where(rolling < turn / 2, rolling, rolling - turn) if signed else rolling))
    assert said == what
    assert np.diff(counted) == pytest.approx(5e-3 * unit * np.ones(2599), rel=1e-4)


@pytest.mark.parametrize("back", [0.3, 5.0, 100.0])
def test_a_clock_that_is_set_back_is_no_counter(back):
    time = np.arange(2600) * 0.005 + 1000.0
    time[1300:] -= back
    assert counted_on(time)[0] is time


@pytest.mark.parametrize("back", [0, 100_000])
def test_joints_stored_one_after_the_other_are_put_together_also_where_the_clock_was_set_back(back):
    stamps = np.arange(0, 2000, 5)
    stamps[200:] -= back
    known = np.repeat([[True, False], [False, True]], 400, axis=0)
    order, notes = in_order(np.concatenate([stamps, stamps + 1]), known)
    assert np.array_equal(order, np.stack([np.arange(400), np.arange(400, 800)], axis=1).ravel())
    assert notes == []


def test_joints_that_come_in_bursts_one_after_the_other_are_put_together():
    stamps = np.arange(0, 1000, 5)
    stored = np.stack([stamps.reshape(20, 10), stamps.reshape(20, 10) + 1], axis=1).ravel()
    known = np.tile(np.repeat([[True, False], [False, True]], 10, axis=0), (20, 1))
    order, _ = in_order(stored, known)
    assert np.array_equal(stored[order], np.sort(stored))


def test_what_two_recorders_stored_counts_once_and_readings_at_rest_all():
    stamps = np.array([0, 0, 5, 5, 10, 0, 5, 10, 15])
    readings = np.array([1.0, 1.0, 2.0, 3.0, np.nan, 1.0, 2.5, np.nan, 4.0])
    assert np.flatnonzero(recorded_again(stamps, readings[:, None])).tolist() == [5, 7]
