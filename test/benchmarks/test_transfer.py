# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Controllers get one try each on hidden rigs; the table counts those that stood."""

import pytest

pytest.importorskip("casadi")

from benchmarks.transfer import BEGIN, END, KINDS, MODELS, OTHERS, PAGE, TASKS, stand, swing, table, written
from cdp_ident.configuration.fitted_model import fitted_model
from reference.truths import truth


@pytest.fixture(scope="module")
def plain():
    return truth("none", 3)


def test_with_the_rig_s_own_values_it_stands_and_swings_up(plain):
    known = fitted_model(dict(plain.setting.values), "known")
    for tried in (stand(plain, known, friction=True, delay=1), swing(plain, known, friction=True, delay=1)):
        assert tried.stood
        assert tried.error < 0.2
        assert tried.travel < plain.setting.size


def test_with_values_of_another_rig_it_falls(plain):
    values = dict(plain.setting.values)
    tried = stand(plain, fitted_model(values | {"L": 3.0 * values["L"]}, "other"), True, 1)
    assert not tried.stood


def test_the_table_counts_and_stands_in_its_page():
    good = {"stood": True, "error": 0.1, "travel": 0.6}
    bad = {"stood": False, "error": 1.0, "travel": 0.1}
    names = (*MODELS, *OTHERS)
    results = [
        {"job": KINDS[0], "size": 2.0, "found": [], **{name: dict.fromkeys(TASKS, of) for name in names}}
        for of in (good, bad, {"no design": "the cart cannot"})
    ]
    assert list(table(results).rows[0]) == ["nominal", *["1 of 3", "5.7, 5.7", "0.3, 0.3"] * 2]
    page = written(PAGE.read_text(), results)
    assert page.count("1 of 3") == 2 * len(names)
    assert written(page, results) == page
    assert page.count(BEGIN) == page.count(END) == 1
