# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Methods of finding the parameters are put side by side."""

from benchmarks import search
from benchmarks.search import OURS, Result
from scenarios.start_given import Arrival


def rows_of(results):
    return {row[0]: row[1:] for row in search.table_of(results).rows}


def test_medians_and_what_they_are_to_ours():
    results = [Result(name, 0, Arrival(9.0, 1), 9.0, 1.0) for name in search.METHODS if name not in (OURS, "pycma")]
    for seed in range(10):
        results.append(Result(OURS, seed, Arrival(1.0, 280, 9), 0.016, 0.1))
        close = 1.04 if seed < 7 else 3.0
        results.append(Result("pycma", seed, Arrival(close, 2000 + seed), 0.016 * close + 1e-3 * seed, 0.3))
    rows = rows_of(results)
    assert rows[OURS] == ("10 of 10", "0.016", "0.016 to 0.016", "280", "9", "0.10", "1.0")
    assert rows["pycma"] == ("7 of 10", "0.021", "0.019 to 0.055", "2 004", "", "0.30", "3.0")
    assert rows["IGA"][0] == "0 of 1"


def test_a_method_of_which_nothing_came_says_why():
    results = [Result(name, 0, Arrival(1.0, 1), 0.016, 1.0) for name in search.METHODS if name != "TGA"]
    results.append(Result("TGA", 0, failure="the process ended with -9"))
    assert rows_of(results)["TGA"] == ("the process ended with -9", *[""] * 6)
