# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The reference that other tests of this folder stand on."""

import numpy as np
import pytest

from reference.own_units import Rig, motion
from reference.pendulum import TABLE_5, accelerations

START = np.array([2.0, 2.6, 0.0, 0.0])
TIME = np.arange(2000) * 0.05


def test_it_moves_as_the_lagrangian_says():
    m1, m2, m0, l1, l2, J1, J2, c1, c2, L, g = TABLE_5.values()
    A22, unit = m1 * l1**2 + J1 + (m2 + m0) * L**2, np.sqrt(L / g)
    groups = np.array([m2 * L * l2, m2 * l2**2 + J2, (m1 * l1 + (m2 + m0) * L) * L, c1 * unit, c2 * unit]) / A22
    state = np.array([2.0, 0.4, 1.5, -2.0])
    in_seconds = np.concatenate([state[:2], state[2:] / unit])
    ours, _ = Rig(*groups).accelerations(state, (1, -1))
    assert ours / unit**2 == pytest.approx(accelerations(TABLE_5, in_seconds, 0.0), rel=1e-9)


def test_joints_stick_while_the_torque_suffices_and_never_creep():
    rig = Rig(A23=0.5, A33=0.4, a1=1.4, dry1=0.02, dry2=0.06)
    states = motion(rig, START, TIME)
    relative = states[:, 3] - states[:, 2]
    stuck = np.abs(relative) < 1e-9
    assert 0.1 < np.mean(stuck) < 1.0
    assert np.ptp(np.diff(states[:, :2], axis=1)[-200:]) < 1e-9
    for state in states[stuck]:
        _, torque = rig.accelerations(state, (int(np.sign(state[2])) or 1, 0))
        assert abs(torque[1]) <= 0.06 * (1 + 1e-6) or abs(state[2]) < 1e-9
