# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The torque that a model lacks is given along the motion, with where it is and how sure it is."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.tracing.missing_torque import MissingTorque
from reference import pendulum
from reference.pendulum import TABLE_5
from scenarios.paper_rig import A22
from scenarios.swings import TIME, fitted, measured, recorded

SIZE, TURNS = 4e-3, 2.0
"""Of a torque in the outer joint over its angle [N m]."""


def hidden(angle):
    return SIZE * np.sin(TURNS * angle)


@pytest.fixture(scope="module")
def found():
    def torque(time, state):
        of_joint = hidden(state[1] - state[0])
        return -of_joint, of_joint

    states = pendulum.motion(TABLE_5, (1.5, 1.2, 0.0, 0.0), TIME, torque=torque, tolerance=1e-9)
    return states, fitted(recorded([measured(states[:, :2], np.random.default_rng(0))]))


def test_it_is_what_was_hidden_within_its_standard_deviation_beside_angles_and_speeds_at_its_time(found):
    states, of = found
    missing = MissingTorque.of(of)
    theta1, theta2, omega1, omega2 = (np.interp(missing.time, TIME, column) for column in states[:, :4].T)
    true = hidden(theta2 - theta1) / A22
    assert of.is_missing[1]
    inside = slice(3, -3)
    assert np.corrcoef(missing.torque[inside, 1], true[inside])[0, 1] > 0.95
    off = (missing.torque[inside, 1] - true[inside]) / missing.std[inside, 1]
    assert np.sqrt(np.mean(off**2)) < 1.2
    np.testing.assert_allclose(missing.angle, np.stack([theta1 - np.pi, theta2 - theta1], axis=1), atol=0.02)
    np.testing.assert_allclose(missing.speed, np.stack([omega1, omega2 - omega1], axis=1), atol=0.5)
    # It is zero in a joint where none is missing.
    outer = MissingTorque.of(replace(of, is_missing=np.array([False, True])))
    assert not np.any(outer.torque[:, 0])
    assert not np.any(outer.std[:, 0])
    assert np.all(outer.std[:, 1] > 0.0)


def test_each_value_has_its_trial_and_its_time_there(found):
    _, of = found
    (swing,) = of.recorded.swings
    twice = replace(
        of,
        recorded=replace(of.recorded, swings=(swing, replace(swing, trial=3, begin=100.0))),
        states=of.states * 2,
        impulses=of.impulses * 2,
    )
    missing = MissingTorque.of(twice)
    half = len(missing.time) // 2
    assert set(missing.trial[:half]) == {0}
    assert set(missing.trial[half:]) == {3}
    np.testing.assert_allclose(missing.time[half:], missing.time[:half] + 100.0)
