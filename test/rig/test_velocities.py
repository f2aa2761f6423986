# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Velocities of positions that an encoder has counted."""

import math

import numpy as np
import pytest

from cdp_ident.rig.velocities import Velocities

PERIOD = 0.005
COUNT = math.tau / 8000


def test_constant_acceleration_has_no_lag() -> None:
    estimated = Velocities(0.05)
    for time in np.arange(0, 1, PERIOD).tolist():
        found = estimated.update(round(time * 1e9), (3.0 * time**2, -time))
    assert found == pytest.approx((6.0 * (1.0 - PERIOD), -1.0))


def test_counts_are_much_less_noisy_than_differences_of_them() -> None:
    times = np.arange(0, 5, PERIOD)
    counted = np.round(np.sin(6.0 * times) / COUNT) * COUNT
    estimated, errors = Velocities(0.05), []
    for time, position in zip(times.tolist(), counted.tolist(), strict=True):
        for velocity in estimated.update(round(time * 1e9), (position,)):
            errors.append(velocity - 6.0 * math.cos(6.0 * time))
    raw = np.diff(counted) / PERIOD - 6.0 * np.cos(6.0 * times[1:])
    assert np.std(errors) < 0.5 * np.std(raw)


@pytest.mark.parametrize("step", [-3.0, 1.0])
def test_nothing_is_said_of_too_few_samples_nor_across_a_gap(step: float) -> None:
    estimated = Velocities(0.05)
    times = [number * PERIOD for number in range(10)]
    known = [bool(estimated.update(round(time * 1e9), (time,))) for time in [*times, *(time + step for time in times)]]
    assert known == 2 * [*3 * [False], *7 * [True]]
