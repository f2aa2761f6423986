# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from reference.pendulum import SYMBOLS
from reference.settings import COUNTS, GRAVITY, NOMINAL_ERROR, RATES, RULER, SIZES, draw_setting

SETTINGS = [draw_setting(np.random.default_rng(seed)) for seed in range(60)]


def test_the_same_seed_draws_the_same():
    assert draw_setting(np.random.default_rng(3)).values == SETTINGS[3].values


def test_rigs_and_encoders_vary():
    sizes = [setting.size for setting in SETTINGS]
    assert SIZES[0] <= min(sizes) < 0.4
    assert 2.5 < max(sizes) <= SIZES[1]
    assert {setting.rate for setting in SETTINGS} == set(RATES)
    assert {setting.counter.counts for setting in SETTINGS} == set(COUNTS)
    correlated = [setting.counter.memory > 0.0 for setting in SETTINGS]
    assert any(correlated)
    assert not all(correlated)


def test_nominal_values_are_off_lengths_by_what_a_ruler_is_and_g_by_what_it_varies():
    off = np.array([[setting.nominal[s] / setting.values[s] - 1.0 for s in SYMBOLS] for setting in SETTINGS])
    assert np.abs(off).max() <= NOMINAL_ERROR
    assert np.abs(off[:, :9]).max(axis=0).min() > 0.2
    assert 0.0 < np.abs(off[:, 9] * [setting.values["L"] for setting in SETTINGS]).max() < 4.0 * RULER
    assert 0.002 < np.abs(off[:, 10]).max() <= 9.81 / GRAVITY[0] - 1.0


@pytest.mark.parametrize("setting", SETTINGS[:10])
def test_trials_last_ten_seconds_and_more(setting):
    assert len(setting.starts) == len(setting.times) == 3
    for times in setting.times:
        assert 10.0 - 1e-9 <= times[-1] + 1.0 / setting.rate <= 15.0 + 1.0 / setting.rate
        assert np.diff(times) == pytest.approx(1.0 / setting.rate)
