# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motion with dry friction as it is: the energy that it takes, the load of a bearing, and torques beside it."""

import math

import numpy as np
import pytest

from reference import pendulum, torques
from reference.dry_friction import DryFriction
from reference.mechanics import Rig
from reference.pendulum import TABLE_2, TABLE_5
from reference.plant import Plant
from reference.sticking import motion, path

TIMES = np.arange(1601) / 200.0
START = (3.9, 4.4, 0.0, 0.0)


@pytest.mark.parametrize("values", [TABLE_2, TABLE_5])
def test_without_dry_friction_it_is_the_lagrangian_s_motion(values):
    start = (2.2, 3.9, 1.0, -2.0)
    assert np.abs(motion(values, start, TIMES) - pendulum.motion(values, start, TIMES)).max() < 1e-9


def test_dry_friction_takes_its_torque_times_the_angle_rubbed_over():
    values = {**TABLE_5, "c1": 0.0, "c2": 0.0}
    found = path(Plant(Rig(values), DryFriction(0.1)), START, TIMES)
    turns = np.searchsorted(found.event_times, TIMES)
    stops = path(Plant(Rig(values), DryFriction(0.1)), START, np.union1d(TIMES, found.event_times)).states[:, 0]
    assert turns[-1] > 3
    lost = np.ptp(pendulum.energy(values, found.states[[0, -1]]))
    assert lost == pytest.approx(0.1 * np.abs(np.diff(stops)).sum(), abs=1e-9)


def test_the_load_of_a_bearing_at_rest_is_the_weight_that_hangs_on_it():
    weight = (TABLE_5["m1"] + TABLE_5["m2"] + TABLE_5["m0"]) * TABLE_5["g"]
    lever, angle = 0.01, 0.05
    start = (math.pi + angle, math.pi, 0.0, 0.0)
    inner = TABLE_5["m1"] * TABLE_5["l1"] + (TABLE_5["m2"] + TABLE_5["m0"]) * TABLE_5["L"]
    needed = inner * TABLE_5["g"] * math.sin(angle)
    for torque, moves in ((needed - lever * weight + 1e-6, False), (needed - lever * weight - 1e-6, True)):
        last = motion(TABLE_5, start, TIMES[:20], DryFriction(torque, lever=lever), DryFriction(1.0))[-1]
        assert np.array_equal(last, start) != moves


def test_torques_act_as_the_lagrangian_with_them_says():
    def added(time, state):
        hanging, rate = state[0] - math.pi, state[3] - state[2]
        across = -0.02 * (state[1] - state[0] - 0.2) - 0.001 * rate * abs(rate)
        own = 0.01 * math.sin(5 * hanging + 0.3) - 0.002 * state[2] * abs(state[2])
        return own - across, across - 0.001 * state[3] * abs(state[3])

    acting = (
        torques.spring("outer", 0.02, 0.2),
        torques.quadratic("outer", 0.001),
        torques.cogging("inner", 0.01, 5, 0.3),
        torques.drag("inner", 0.002),
        torques.drag("outer", 0.001),
    )
    expected = pendulum.motion(TABLE_5, START, TIMES, torque=added, tolerance=3e-14)
    away = np.abs(motion(TABLE_5, START, TIMES, torques=acting) - expected).max(axis=0)
    # A step over a turning point, where a square of a speed with its sign has a kink, is of second order in both.
    assert (away < (1e-9, 1e-9, 1e-8, 1e-8)).all()


def test_presliding_becomes_dry_friction_as_it_gets_stiffer():
    dry = motion(TABLE_5, START, TIMES[:600], DryFriction(0.02))[:, :2]
    away = [
        np.abs(motion(TABLE_5, START, TIMES[:600], torques=[torques.dahl("inner", 0.02, stiffness)])[:, :2] - dry).max()
        for stiffness in (10.0, 100.0, 1000.0)
    ]
    # What is missed of it after each turn lasts as long as a turn takes: it goes with the root of the angle.
    assert away[2] == pytest.approx(away[1] / 10**0.5, rel=0.1)
    assert away[2] < 1e-3
