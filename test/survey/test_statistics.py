# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A change and a rig that differs are found where they are, and chance seldom looks like one."""

import numpy as np
import pytest

from cdp_ident.survey.statistics import Series, appearance, changes, differing

LEVEL = 0.05


def series(rng, count, *shifts, scatter=3.0):
    """Return values and standard deviations that are too small by a factor, with a shift of 1 at each instant."""
    std = rng.uniform(0.01, 0.05, count)
    values = 5.0 + scatter * std * rng.standard_normal(count)
    for instant in shifts:
        values[instant:] += 1.0
    return Series(values, std)


@pytest.mark.parametrize("count", [4, 6, 20])
def test_a_change_is_found_where_it_is(count):
    rng = np.random.default_rng(10 + count)
    (found,) = changes(series(rng, count, count // 2, scatter=0.3), LEVEL)
    assert found.index == count // 2
    assert found.p_value < 0.02


def test_several_changes_are_found_in_order():
    found = changes(series(np.random.default_rng(1), 30, 10, 22), LEVEL)
    assert [change.index for change in found] == [10, 22]


def test_the_last_value_alone_may_have_changed():
    found = changes(series(np.random.default_rng(2), 12, 11), LEVEL)
    assert [change.index for change in found] == [11]


@pytest.mark.parametrize("count", [4, 10, pytest.param(60, marks=pytest.mark.campaign)])
@pytest.mark.parametrize("scatter", [0.2, 5.0])
def test_false_alarms_are_no_more_frequent_than_the_level_whatever_the_scatter(count, scatter):
    rng = np.random.default_rng(count)
    number = 2000
    alarms = sum(bool(changes(series(rng, count, scatter=scatter), LEVEL)) for _ in range(number))
    # Bonferroni's inequality gives away a part of the level where instants are many.
    assert 0.2 * LEVEL * number < alarms < LEVEL * number + 3 * np.sqrt(LEVEL * number)


def test_the_level_is_that_of_all_series_together():
    shifted = series(np.random.default_rng(3), 6, 3)
    (alone,) = changes(shifted, LEVEL)
    (of_five,) = changes(shifted, LEVEL, tests=5)
    assert of_five.p_value == pytest.approx(5 * alone.p_value)
    assert changes(shifted, LEVEL, tests=10**6) == []


@pytest.mark.parametrize("values", [[], [1.0], [1.0, 1.001, 9.0], [2.0, 2.0, 2.0, 2.0]])
def test_too_few_or_equal_values_show_no_change(values):
    assert changes(Series(np.array(values), np.full(len(values), 0.1)), LEVEL) == []


def test_what_is_found_from_a_day_on_has_appeared_then():
    found = appearance([False] * 8 + [True] * 8, LEVEL)
    assert found.index == 8
    assert found.p_value == pytest.approx(15 / 6435)  # of 12870 orders two are as clear, at each of 15 instants
    assert appearance([True] * 8 + [False] * 8, LEVEL).index == 8


@pytest.mark.parametrize("found", [[False] * 9 + [True], [True] * 10, [True, False] * 5, [False, False, True]])
def test_what_is_found_now_and_then_has_not_appeared(found):
    assert appearance(found, LEVEL) is None


def test_a_mean_scatters_as_its_values_do():
    both = Series(np.array([1.0, 3.0]), np.array([0.1, 0.1]))
    assert both.mean == 2.0
    assert both.std_of_mean == pytest.approx(1.0)
    assert both[:1].std_of_mean == pytest.approx(0.1)


def rigs(rng, *means, count=6):
    std = 0.02
    return {
        f"rig{k}": Series(mean + 2 * std * rng.standard_normal(count), np.full(count, std))
        for k, mean in enumerate(means)
    }


def test_the_rig_that_differs_is_told_and_no_other():
    (found,) = differing(rigs(np.random.default_rng(0), 1.0, 1.0, 1.5, 1.0), LEVEL)
    assert (found.rig, found.others) == ("rig2", ("rig0", "rig1", "rig3"))
    assert found.value - found.others_value == pytest.approx(0.5, abs=4 * found.std)


@pytest.mark.parametrize(
    ("means", "expected"),
    [
        ((1.0, 3.0, 1.0, 2.0, 1.0), [("rig1", ("rig0", "rig2", "rig3", "rig4")), ("rig3", ("rig0", "rig2", "rig4"))]),
        ((1.0, 2.0), [("rig1", ("rig0",))]),
    ],
    ids=["one after the other", "of two the second"],
)
def test_rigs_that_differ_are_told(means, expected):
    found = differing(rigs(np.random.default_rng(len(means)), *means), LEVEL)
    assert [(difference.rig, difference.others) for difference in found] == expected


def test_rigs_with_one_value_each_cannot_be_compared():
    assert differing(rigs(np.random.default_rng(3), 1.0, 2.0, count=1), LEVEL) == []
    assert differing({}, LEVEL) == []


@pytest.mark.parametrize("count", [2, 5])
def test_false_alarms_of_rigs_are_no_more_frequent_than_the_level(count):
    rng = np.random.default_rng(count)
    number = 1000
    alarms = sum(bool(differing(rigs(rng, *[1.0] * count, count=4), LEVEL)) for _ in range(number))
    assert 0.2 * LEVEL * number < alarms < LEVEL * number + 3 * np.sqrt(LEVEL * number)
