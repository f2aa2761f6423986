# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The rig that differs is found, and chance seldom looks like one."""

import numpy as np
import pytest

from cdp_ident.survey.rigs import differing

LEVEL = 0.05


def rigs(rng, *means, count=6):
    std = 0.02
    return {
        f"rig{k}": (mean + 2 * std * rng.standard_normal(count), np.full(count, std)) for k, mean in enumerate(means)
    }


def test_the_rig_that_differs_is_told_and_no_other():
    (found,) = differing(rigs(np.random.default_rng(0), 1.0, 1.0, 1.5, 1.0), LEVEL)
    assert (found.rig, found.others) == ("rig2", ("rig0", "rig1", "rig3"))
    assert found.value - found.others_value == pytest.approx(0.5, abs=4 * found.std)


def test_several_that_differ_are_told_one_after_the_other():
    found = differing(rigs(np.random.default_rng(1), 1.0, 3.0, 1.0, 2.0, 1.0), LEVEL)
    assert [difference.rig for difference in found] == ["rig1", "rig3"]
    assert found[1].others == ("rig0", "rig2", "rig4")


def test_of_two_rigs_the_second_differs_from_the_first():
    (found,) = differing(rigs(np.random.default_rng(2), 1.0, 2.0), LEVEL)
    assert (found.rig, found.others) == ("rig1", ("rig0",))


def test_rigs_with_one_value_each_cannot_be_compared():
    assert differing(rigs(np.random.default_rng(3), 1.0, 2.0, count=1), LEVEL) == []
    assert differing({}, LEVEL) == []


@pytest.mark.parametrize("count", [2, 5])
def test_false_alarms_are_no_more_frequent_than_the_level(count):
    rng = np.random.default_rng(count)
    number = 1000
    alarms = sum(bool(differing(rigs(rng, *[1.0] * count, count=4), LEVEL)) for _ in range(number))
    assert 0.2 * LEVEL * number < alarms < LEVEL * number + 3 * np.sqrt(LEVEL * number)
