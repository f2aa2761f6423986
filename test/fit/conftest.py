# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motions of pendulums of any size, sticking ones among them, as encoders show them."""

from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from cdp_ident.trial.trial import Trial
from reference.own_units import Rig, motion

PLAIN = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01)
START = np.array([2.0, 2.6, 0.0, 0.0])


@cache
def _table(rig, start, units):
    """A motion in the rig's units; between the entries cubics are good to a microradian."""
    clock = np.arange(round(units / 0.02) + 2) * 0.02
    states = motion(rig, np.array(start), clock)
    return CubicHermiteSpline(clock, states[:, :2], states[:, 2:])


@pytest.fixture
def measured():
    """Return a function that measures a rig of length L at a rate [Hz], for so many units of its time."""

    def measure(rig=PLAIN, length=0.4, rate=200.0, units=60.0, noise=1e-3, start=START, seed=0):
        unit = np.sqrt(length / 9.81)
        time = np.arange(0.0, units * unit, 1.0 / rate)
        theta = _table(rig, tuple(start), units)(time / unit)
        rng = np.random.default_rng(seed)
        return Trial("trial", time, theta + rng.normal(scale=noise, size=theta.shape))

    return measure


@pytest.fixture
def true_groups():
    """Return a function that gives a rig's base parameters, and its torques of dry friction, in SI units."""

    def groups(rig, length):
        unit = np.sqrt(length / 9.81)
        return (
            np.array([rig.A23, rig.A33, rig.a1 / length, rig.c1 / unit, rig.c2 / unit]),
            np.array([rig.dry1, rig.dry2]) / unit**2,
        )

    return groups
