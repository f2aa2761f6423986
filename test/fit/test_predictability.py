# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from cdp_ident.fit.predictability import predictability
from cdp_ident.trial.balance import motion_on_grid
from cdp_ident.trial.scales import Scales
from reference.own_units import Rig, motion

RIG = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.004, c2=0.002)
GROUPS = np.array([0.5, 0.4, 1.4, 0.004, 0.002])
"""Of a rig with L = 1 m where g = 1 m/s^2, so that its unit of time is a second."""
CALM, WHIRLING = np.array([3.7, 2.5, 0.0, 0.0]), np.array([0.24, 0.3, 0.0, 0.0])
SPACING, HALF_WIDTH = 0.025, 0.2
LOST, LONGEST = 0.2, 30.0


def lasts(start, noise):
    time = np.arange(2400) * SPACING
    smoothed = motion_on_grid(time, motion(RIG, start, time)[:, :2], None, Scales(1.0))
    return predictability(smoothed, GROUPS, 1.0, 1.0, np.full(2, noise), SPACING, HALF_WIDTH, LONGEST)


def test_a_calm_motion_is_followed_to_its_end():
    assert lasts(CALM, 1e-3) == LONGEST


def test_a_whirling_one_is_lost_the_sooner_the_larger_the_noise():
    fine, coarse = lasts(WHIRLING, 1e-4), lasts(WHIRLING, 1e-2)
    assert coarse < 0.7 * fine < LONGEST


def test_simulations_from_disturbed_starts_are_lost_about_then():
    noise = 3e-3
    rng = np.random.default_rng(3)
    time = np.arange(500) * SPACING
    samples = 2.0 * HALF_WIDTH / SPACING
    scatter = noise * np.sqrt(np.repeat([9 / 4 / samples, 75 / 4 / (samples * HALF_WIDTH**2)], 2))
    states = motion(RIG, WHIRLING, np.arange(2400) * SPACING)
    amplitude = np.minimum(np.std(states[:, :2], axis=0), 1.0)
    lasted = []
    for begin in range(0, 1500, 150):
        disturbed = motion(RIG, states[begin] + rng.normal(scale=scatter), time, 1e-7)
        lost = np.abs(disturbed - states[begin : begin + 500])[:, :2] / amplitude > LOST
        lasted.append(time[np.argmax(lost.any(axis=1))] if lost.any() else np.inf)
    assert lasts(WHIRLING, noise) == pytest.approx(np.quantile(lasted, 0.1, method="lower"), rel=0.6)
