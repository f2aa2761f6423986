# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.trial.trial import Trial, joined

RATE, SPACING = 20.0, 0.01
BEGINS = (0.0, 1.2, 2.5)


@pytest.fixture
def stretches():
    """Of one even rotation; the later ones have lost some turns."""
    made = []
    for number, begin in enumerate(BEGINS):
        time = SPACING * np.arange(100)
        angle = RATE * (begin + time) - 2 * np.pi * number
        made.append(Trial("spin", time, np.column_stack([angle, -angle]), cart=begin + time, start=5.0 + begin))
    return made


def test_joined_stretches_are_one_motion_with_the_turns_that_its_speed_asks_for(stretches):
    trial = joined(stretches)
    assert trial.theta == pytest.approx(np.column_stack([RATE * trial.time, -RATE * trial.time]))
    assert trial.cart == pytest.approx(trial.time)
    assert (trial.start, trial.breaks) == (5.0, (100, 200))
    assert trial.bounds == ((0, 100), (100, 200), (200, 300))


def test_a_trial_is_taken_apart_into_its_stretches(stretches):
    for stretch, apart in zip(stretches, joined(stretches).stretches, strict=True):
        assert apart.time == pytest.approx(stretch.time)
        assert apart.start == pytest.approx(stretch.start)
        assert np.diff(apart.theta, axis=0) == pytest.approx(np.diff(stretch.theta, axis=0))
        assert apart.breaks == ()


def test_a_trial_without_gaps_is_its_only_stretch(stretches):
    assert stretches[0].stretches == (stretches[0],)
    assert joined(stretches[:1]).breaks == ()


def test_outliers_stay_with_the_stretch_that_they_were_in(stretches):
    spikes = [(5.3,), (), (7.6, 7.9)]
    trial = joined([replace(stretch, outliers=at) for stretch, at in zip(stretches, spikes, strict=True)])
    assert trial.outliers == (5.3, 7.6, 7.9)
    assert [apart.outliers for apart in trial.stretches] == spikes


def test_the_cart_s_acceleration_is_the_second_derivative_of_its_position():
    time = np.arange(2000) / 200
    position = 0.1 * np.sin(3 * time) + np.random.default_rng(0).normal(0, 2e-5, 2000)
    found = Trial("cart", time, np.zeros((2000, 2)), position).cart_acceleration
    assert np.abs(found - -0.9 * np.sin(3 * time))[100:-100].max() < 0.1
