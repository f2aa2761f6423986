# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Each rule can be switched off, and is on again afterwards."""

import importlib

import pytest

from benchmarks._scores import Score
from benchmarks.rules import RULES, table_of


def value_of(rule):
    module, _, path = rule.place.partition(":")
    value = importlib.import_module(module)
    for name in path.split("."):
        value = getattr(value, name)
    return value


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_a_rule_is_off_for_a_while(rule):
    before = value_of(rule)
    with rule.off():
        assert value_of(rule) is rule.instead
    assert value_of(rule) is before


def test_the_table_says_what_became_worse_and_better_without_a_rule():
    def score(seed, *false):
        return Score("none", seed, "equations", false=false, after=1.0, before=1.0, seconds=2.0)

    found = [((), score(0)), ((), score(1, "spring")), (("tails",), score(0, "magnet")), (("tails",), score(1))]
    columns = [list(column.cells) for column in table_of(found).columns]
    assert [cells[1] for cells in columns] == ["tails", "2", "1", "1", "1.00", "none 0 equations: FALSE"]
