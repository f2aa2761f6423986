# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from cdp_ident.fit.thinning import thinned
from cdp_ident.trial.trial import Trial

NOISE = 1e-3


def swing(rate=2000.0, noise=0.0, cart=False):
    time = np.arange(0.0, 10.0, 1.0 / rate)
    theta = np.column_stack([np.sin(7.0 * time), np.cos(11.0 * time)])
    theta += np.random.default_rng(0).normal(scale=noise, size=theta.shape) if noise else 0.0
    return Trial("swing", time, theta, 0.1 * np.sin(5.0 * time) if cart else None)


def truth(trial):
    time = trial.time + trial.start
    return np.column_stack([np.sin(7.0 * time), np.cos(11.0 * time)])


def test_neither_the_motion_nor_the_cart_s_is_changed_and_it_says_how_many_samples_there_were():
    fewer = thinned(swing(cart=True), 10)
    assert fewer.notes == ("20000 samples were averaged into 2000, 10 into one: the motion is slower than that",)
    assert np.abs(fewer.theta - truth(fewer))[1:-1].max() < 5e-7
    assert fewer.cart == pytest.approx(0.1 * np.sin(5.0 * (fewer.time + fewer.start)), abs=1e-6)
    few = swing(rate=50.0)
    assert thinned(few, 1) is few


def test_noise_is_averaged_and_stays_nearly_white():
    fewer = thinned(swing(noise=NOISE), 16)
    error = (fewer.theta - truth(fewer)).ravel()
    assert np.std(error) == pytest.approx(NOISE / 4.0, rel=0.15)
    assert abs(np.corrcoef(error[2::2], error[:-2:2])[0, 1]) < 0.2


def test_lost_samples_do_not_shift_it():
    trial = swing()
    kept = np.random.default_rng(1).uniform(size=len(trial.time)) > 0.3
    fewer = thinned(Trial("film", trial.time[kept], trial.theta[kept]), 10)
    assert np.abs(fewer.theta - truth(fewer))[1:-1].max() < 2e-5
