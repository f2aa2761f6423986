# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from cdp_ident.trial.scales import Scales, time_scale
from reference.own_units import Rig, motion

PENDULUM = Rig(A23=0.154, A33=0.1005, a1=1.053, c1=0.0072, c2=0.0018)
"""Table 2's, with good bearings, in units in which it may have any size."""


@cache
def table(start, units):
    """A motion in the rig's units; between the entries cubics are good to a microradian."""
    clock = np.arange(round(units / 0.02) + 2) * 0.02
    states = motion(PENDULUM, np.array([*start, 0.0, 0.0]), clock)
    return CubicHermiteSpline(clock, states[:, :2], states[:, 2:])


def swing(length, rate, seconds, noise, lost=0.0, start=(2.0, 2.5)):
    """Times (n,) and angles (n, 2) of a pendulum of a size, on film."""
    unit = np.sqrt(length / 9.81)
    time = np.arange(round(seconds * rate)) / rate
    generator = np.random.default_rng(1)
    theta = table(start, 60.0 * np.ceil(seconds / unit / 60.0))(time / unit)
    kept = generator.random(len(time)) >= lost
    return time[kept], (theta + generator.normal(0, noise, theta.shape))[kept]


@pytest.mark.parametrize(
    ("length", "rate", "seconds", "noise", "lost"),
    [
        (0.05, 60, 10, 1e-3, 0),
        (0.09, 500, 36, 1e-3, 0),
        (0.17, 100, 6, 1e-3, 0.1),
        (0.4, 200, 10, 1e-5, 0),
        (0.4, 50, 10, 1e-2, 0),
        (2.0, 60, 10, 1e-3, 0),
        (2.0, 2000, 10, 1e-3, 0),
    ],
)
@pytest.mark.parametrize("start", [(2.0, 2.5), (1.0, 1.5), (2.9, 3.3)])
def test_the_scale_follows_the_rig_whatever_films_it(length, rate, seconds, noise, lost, start):
    scale = time_scale(*swing(length, rate, seconds, noise, lost, start))
    assert 0.25 < scale / np.sqrt(length / 9.81) < 1.6


def test_wrapped_angles_have_the_same_scale():
    time, theta = swing(0.4, 200, 10, 0, start=(0.4, 0.2))
    assert np.ptp(theta[:, 1]) > 2 * np.pi
    assert time_scale(time, np.mod(theta, 2 * np.pi)) == pytest.approx(time_scale(time, theta), rel=1e-6)


def test_rest_and_a_slow_hand_before_a_swing_do_not_change_its_scale():
    time, theta = swing(0.3, 200, 5, 1e-3)
    rise = np.linspace(np.pi, theta[0], 1000)
    longer = np.concatenate([np.repeat(rise[:1], 500, axis=0), rise, theta])
    assert time_scale(np.arange(len(longer)) / 200, longer) == pytest.approx(time_scale(time, theta), rel=0.2)


def test_what_the_sampling_cannot_resolve_is_no_scale():
    time, theta = swing(0.05, 30, 10, 0)
    assert Scales.of(time, theta).unit == pytest.approx(12 / 30)


@pytest.mark.parametrize("count", [0, 1, 2, 15, 200])
def test_anything_has_a_scale(count):
    assert 0 < Scales.of(np.arange(count) * 0.01, np.zeros((count, 2))).unit < 2
    assert 0 < Scales.of(np.zeros(count), np.ones((count, 2))).unit < 2


@pytest.mark.parametrize("missing", [0.07, 0.12, 2.0])
def test_gaps_between_samples_make_a_motion_no_faster(missing):
    time, angles = swing(0.4, 200, 20, 1e-4)
    kept = time % (0.75 + missing) < 0.75
    assert time_scale(time[kept], angles[kept]) == pytest.approx(time_scale(time, angles), rel=0.15)
