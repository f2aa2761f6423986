# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motion with dry friction as it is, against scipy's integrator with events and the equations that sympy derives."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from reference import pendulum, torques
from reference.dry_friction import DryFriction
from reference.mechanics import Cart, Rig
from reference.pendulum import TABLE_2, TABLE_5
from reference.plant import Plant
from reference.sticking import motion, path

TIMES = np.arange(1601) / 200.0
START = (3.9, 4.4, 0.0, 0.0)


class WithScipy:
    """The same physics again: modes of both joints, each left at a terminal event of `solve_ivp`."""

    def __init__(self, values, frictions):
        self.values, self.frictions = values, frictions

    def size(self, joint, rate):
        f = self.frictions[joint]
        return f.torque + f.extra * math.exp(-((rate / f.speed) ** 2))

    def slopes(self, state, modes):
        """Return the joints' accelerations for the dry torques that the modes mean, and those torques."""

        def joints(t):
            alpha = pendulum.accelerations(self.values, state, 0.0, (t[0] - t[1], t[1]))
            return np.array([alpha[0], alpha[1] - alpha[0]])

        rates = (state[2], state[3] - state[2])
        t = np.array([-m * self.size(j, r) if m else 0.0 for j, (m, r) in enumerate(zip(modes, rates, strict=True))])
        stuck = [j for j in (0, 1) if modes[j] == 0]
        by_torque = np.stack([joints(t + e) - joints(t) for e in np.eye(2)], axis=1)
        t[stuck] = np.linalg.solve(by_torque[np.ix_(stuck, stuck)], -joints(t)[stuck])
        return joints(t), t

    def consistent(self, state, modes):
        accelerations, t = self.slopes(state, modes)
        for j, rate in enumerate((state[2], state[3] - state[2])):
            if abs(rate) > 1e-10:
                if modes[j] * rate < 0 or modes[j] == 0:
                    return False
            elif (modes[j] == 0 and abs(t[j]) > self.size(j, 0.0)) or (modes[j] and modes[j] * accelerations[j] <= 0.0):
                return False
        return True

    def motion(self, start, times):
        state, t, rows = np.array(start), times[0], [np.array(start)]
        modes = next(m for m in MODES if self.consistent(state, m))
        while t < times[-1]:

            def rates(_, y, modes=modes):
                a = self.slopes(y, modes)[0]
                return [y[2], y[3], a[0], a[0] + a[1]]

            def left(joint, modes=modes):
                def event(_, y):
                    if modes[joint]:
                        return modes[joint] * (y[2], y[3] - y[2])[joint] + 1e-15
                    return self.size(joint, 0.0) - abs(self.slopes(y, modes)[1][joint])

                event.terminal, event.direction = True, -1
                return event

            found = solve_ivp(
                rates, (t, times[-1]), state, "DOP853", dense_output=True, events=[left(0), left(1)],
                rtol=1e-11, atol=1e-12, max_step=0.02,
            )  # fmt: skip
            inside = times[(times > t) & (times <= found.t[-1])]
            rows += list(found.sol(inside).T) if len(inside) else []
            state, t = found.y[:, -1], found.t[-1]
            if t < times[-1]:
                joint = 0 if len(found.t_events[0]) else 1
                if modes[joint] == 0:
                    broken = -int(np.sign(self.slopes(state, modes)[1][joint]))
                    options = [tuple(broken if j == joint else m[j] for j in (0, 1)) for m in MODES]
                    modes = next(m for m in options if self.others_consistent(state, m, joint))
                else:
                    state[2 + joint] = 0.0 if joint == 0 else state[2]
                    modes = next(m for m in MODES if self.consistent(state, m))
        return np.array(rows)

    def others_consistent(self, state, modes, joint):
        other = 1 - joint
        rate = (state[2], state[3] - state[2])[other]
        if abs(rate) > 1e-10:
            return modes[other] * rate > 0
        return modes[other] == 0 and abs(self.slopes(state, modes)[1][other]) <= self.size(other, 0.0)


MODES = [(a, b) for a in (0, 1, -1) for b in (0, 1, -1)]
SLIGHT, STRONG = DryFriction(0.01), DryFriction(0.2)
STRIBECK = DryFriction(0.05, 0.1, 0.4)


@pytest.mark.parametrize(
    ("inner", "outer"),
    [
        (SLIGHT, DryFriction(1e-4)),
        (STRONG, DryFriction(1e-4)),
        (SLIGHT, DryFriction(0.05)),
        (STRONG, DryFriction(0.05)),
        (STRIBECK, DryFriction(0.02, 0.03, 0.5)),
    ],
)
def test_agrees_with_events_of_scipy_s_integrator(inner, outer):
    times = TIMES[:901]
    states = motion(TABLE_5, START, times, inner, outer)
    assert np.abs(states - WithScipy(TABLE_5, (inner, outer)).motion(START, times)).max() < 1e-9


@pytest.mark.parametrize("values", [TABLE_2, TABLE_5])
def test_without_dry_friction_it_is_the_lagrangian_s_motion(values):
    start = (2.2, 3.9, 1.0, -2.0)
    assert np.abs(motion(values, start, TIMES) - pendulum.motion(values, start, TIMES)).max() < 1e-9


def test_energy_is_kept_where_nothing_takes_it():
    values = {**TABLE_5, "c1": 0.0, "c2": 0.0}
    energy = pendulum.energy(values, motion(values, (2.0, 4.5, 0.0, 5.0), TIMES))
    assert np.abs(energy - energy[0]).max() < 1e-10


def test_dry_friction_takes_its_torque_times_the_angle_rubbed_over():
    values = {**TABLE_5, "c1": 0.0, "c2": 0.0}
    found = path(Plant(Rig(values), DryFriction(0.1)), START, TIMES)
    turns = np.searchsorted(found.event_times, TIMES)
    stops = path(Plant(Rig(values), DryFriction(0.1)), START, np.union1d(TIMES, found.event_times)).states[:, 0]
    assert turns[-1] > 3
    lost = np.ptp(pendulum.energy(values, found.states[[0, -1]]))
    assert lost == pytest.approx(0.1 * np.abs(np.diff(stops)).sum(), abs=1e-9)


def test_what_is_stuck_does_not_move_at_all():
    found = path(Plant(Rig(TABLE_5), STRONG, DryFriction(0.05)), START, TIMES)
    assert found.event_modes[-1].tolist() == [0, 0]
    at_rest = found.states[found.event_times[-1] < TIMES]
    assert len(at_rest) > 100
    assert np.array_equal(at_rest, np.broadcast_to(at_rest[-1], at_rest.shape))
    alone = np.flatnonzero((found.event_modes == [1, 0]).all(axis=1))[0]
    together = (found.event_times[alone] < TIMES) & (found.event_times[alone + 1] > TIMES)
    assert together.sum() > 3
    assert np.array_equal(found.states[together, 2], found.states[together, 3])


@pytest.mark.parametrize("angle", [0.05, 0.2])
def test_a_pendulum_that_is_let_go_within_its_static_torque_stays_there(angle):
    moment = TABLE_5["m1"] * TABLE_5["l1"] + (TABLE_5["m2"] + TABLE_5["m0"]) * TABLE_5["L"]
    moment += TABLE_5["m2"] * TABLE_5["l2"]
    needed = moment * TABLE_5["g"] * math.sin(angle)
    start = (math.pi + angle, math.pi + angle, 0.0, 0.0)
    outer = DryFriction(1.0)
    stays = motion(TABLE_5, start, TIMES[:20], DryFriction(1.0001 * needed), outer)
    assert np.array_equal(stays[-1], start)
    goes = motion(TABLE_5, start, TIMES[:20], DryFriction(0.9999 * needed), outer)
    assert goes[-1, 0] < start[0]
    higher_at_rest = motion(TABLE_5, start, TIMES[:20], DryFriction(0.5 * needed, 0.5001 * needed, 0.1), outer)
    assert np.array_equal(higher_at_rest[-1], start)


def test_the_load_of_a_bearing_at_rest_is_the_weight_that_hangs_on_it():
    weight = (TABLE_5["m1"] + TABLE_5["m2"] + TABLE_5["m0"]) * TABLE_5["g"]
    lever, angle = 0.01, 0.05
    start = (math.pi + angle, math.pi, 0.0, 0.0)
    inner = TABLE_5["m1"] * TABLE_5["l1"] + (TABLE_5["m2"] + TABLE_5["m0"]) * TABLE_5["L"]
    needed = inner * TABLE_5["g"] * math.sin(angle)
    for torque, moves in ((needed - lever * weight + 1e-6, False), (needed - lever * weight - 1e-6, True)):
        last = motion(TABLE_5, start, TIMES[:20], DryFriction(torque, lever=lever), DryFriction(1.0))[-1]
        assert np.array_equal(last, start) != moves


def test_a_cart_that_cannot_move_is_no_cart():
    held = path(Plant(Rig(TABLE_5), STRONG, SLIGHT), START, TIMES[:400]).states
    soft = path(Plant(Rig(TABLE_5, cart=Cart(1e9, 0.0, 0.0)), STRONG, SLIGHT), START, TIMES[:400])
    assert np.abs(held - soft.states).max() < 1e-7


def test_tilt_turns_gravity():
    angle = 0.1
    turned = np.array([angle, angle, 0.0, 0.0])
    level = motion(TABLE_5, START, TIMES, SLIGHT)
    tilted = path(Plant(Rig(TABLE_5, tilt=angle), SLIGHT), np.array(START) + turned, TIMES).states
    assert np.abs(tilted - turned - level).max() < 1e-9


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
