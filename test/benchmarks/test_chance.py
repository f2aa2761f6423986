# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The bootstrap of the fitted model finds nothing where only chance is."""

import numpy as np
import pytest

from benchmarks.chance import NOISE, NOISES, examine, summary


@pytest.mark.parametrize(
    ("kind", "lag", "correlation"),
    [
        ("white", 1, 0.0),
        ("correlated over 10 samples", 10, np.exp(-1.0)),
        ("oscillates in 40 samples", 20, -np.exp(-0.5)),
        ("oscillates in 40 samples", 40, np.exp(-1.0)),
    ],
)
def test_noise_is_of_the_size_and_memory_that_its_name_says(kind, lag, correlation):
    noise = NOISES[kind](np.random.default_rng(0), 100_000)
    assert np.std(noise, axis=0) == pytest.approx(NOISE, rel=0.03)
    assert np.mean(noise[lag:] * noise[:-lag], axis=0) / NOISE**2 == pytest.approx(correlation, abs=0.05)


@pytest.mark.parametrize("job", ["white/0", *(pytest.param(f"{k}/1", marks=pytest.mark.campaign) for k in NOISES)])
def test_no_effect_is_accepted_where_there_is_none(job):
    assert examine(job)["accepted"] == []


def test_the_table_counts_runs_by_noise_and_over_all():
    runs = [
        {"job": f"white/{seed}", "accepted": ["air_drag.inner"] * (seed == 0), "log10_odds": 2.0 - 5.0 * seed}
        for seed in (0, 1)
    ]
    table = summary(runs)
    assert table.row_count == 2
    assert list(table.columns[2].cells) == ["1", "1"]
    assert list(table.columns[4].cells) == ["-0.5", "-0.5"]
    assert list(table.columns[5].cells) == ["2.0", "2.0"]
