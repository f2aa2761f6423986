# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Intervals are compared with what is true, and counted by noise, rate and what is hidden."""

import numpy as np
import pytest

from benchmarks.coverage import BEGIN, EFFECTS, END, NOISES, PAGE, RATES, STRENGTHS, examine, table, written

pytestmark = pytest.mark.long


def test_a_run_tells_what_was_found_and_how_far_it_is_off():
    seed = EFFECTS.index("air_drag.outer")
    result = examine(f"white/60/clear/{seed}")
    assert (result["hidden"], result["found"]) == (EFFECTS[seed], [EFFECTS[seed]])
    deviations = [*result["base"], *result["effects"]]
    assert len(deviations) == 6
    assert np.abs(deviations).max() < 5.0


@pytest.mark.campaign
def test_each_effect_is_found_with_the_strength_that_was_hidden():
    off = [examine(f"white/60/clear/{seed}") for seed in range(len(EFFECTS))]
    assert [result["found"] for result in off] == [[effect] for effect in EFFECTS]
    deviations = np.concatenate([[*result["base"], *result["effects"]] for result in off])
    assert len(deviations) == 6 * len(EFFECTS)
    assert np.abs(deviations).max() < 5.0
    assert np.mean(deviations**2) == pytest.approx(1.0, abs=0.7)
    assert all(result["whole"] for result in off)


def result(deviation, seed=0, found=(), hidden=""):
    job = f"white/60/{'clear' if hidden else 'nothing'}/{seed}"
    effects = [deviation] if hidden in found else []
    return {"job": job, "hidden": hidden, "found": list(found), "base": [deviation] * 5, "effects": effects}


def test_runs_in_which_something_else_was_found_are_counted_apart():
    effect = EFFECTS[0]
    results = [
        result(1.9),
        result(2.0, 1),
        result(0.0, 0, [effect], effect),
        result(9.0, 1, [], effect),
        result(9.0, 2, [effect, EFFECTS[1]], effect),
    ]
    nothing, clear = table(results).rows
    assert nothing == ("white", "60", "nothing", "2 of 2", "50 ± 35 %", "", "")
    assert clear == ("white", "60", "clear", "1 of 3", "100 ± 0 %", "100 ± 0 %", "0 ± 0 %")


def test_the_table_takes_its_place_in_the_page_which_has_a_row_for_each_noise_rate_and_strength():
    page = PAGE.read_text(encoding="utf-8")
    new = written(page, [result(1.9)])
    assert "| white | 60 | nothing | 1 of 1 | 100 ± 0 % |" in new
    assert written(new, [result(1.9)]) == new
    around = [(of.partition(BEGIN)[0], of.partition(END)[2]) for of in (page, new)]
    assert around[0] == around[1]
    of_page = page.partition(BEGIN)[2].partition(END)[0]
    rows = [f"| {noise} | {rate} | {strength} |" for noise in NOISES for rate in RATES for strength in STRENGTHS]
    assert [row for row in rows if of_page.count(row) != 1] == []
