# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can be shown."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.diagnosis.evaluation import free_run
from cdp_ident.errors import SimulationError
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.model.weights import Weight
from cdp_ident.replay.scene import Free, Replay, Start
from cdp_ident.trial.load import load_trial
from reference.pendulum import TABLE_5
from reference.weights import with_weight
from scenarios.driven import FRICTION, NOISE, driven_by_motors

BAG = Path(__file__).parents[2] / "bags/swing_check"
MODEL = fitted_model(NOMINAL | {"c1": 0.01, "effects.encoder_offset.outer.offset": 0.01}, "test")
OTHER = fitted_model(NOMINAL | {"c1": 0.02}, "test")


@pytest.fixture(scope="module")
def trial():
    return load_trial(BAG)


def test_a_replay_is_the_free_run_that_reports_evaluate(trial):
    frames = Replay(trial, MODEL).frames(trial.time)
    theta = np.cumsum([frame.simulated[1:] for frame in frames], axis=1)
    expected = free_run(MODEL.motion, MODEL.values, trial, MODEL.trial(), 2.5)
    np.testing.assert_allclose(theta, expected, rtol=0, atol=1e-9)


def test_a_replay_of_a_trial_with_a_weight_is_that_of_a_heavier_rod(trial):
    weighted = replace(trial, weights=(Weight("outer", 0.05, 0.3),))
    theta = np.cumsum([frame.simulated[1:] for frame in Replay(weighted, MODEL).frames(trial.time)], axis=1)
    heavier = fitted_model(
        with_weight(NOMINAL | {"c1": 0.01}, "outer", 0.05, 0.3) | {"effects.encoder_offset.outer.offset": 0.01}, "test"
    )
    expected = free_run(heavier.motion, heavier.values, trial, heavier.trial(), 2.5)
    np.testing.assert_allclose(theta, expected, rtol=0, atol=1e-6)


def test_a_replay_of_a_driven_trial_is_driven_as_that_was():
    driven = driven_by_motors(1)
    model = fitted_model({**TABLE_5, "effects.quadratic_friction.outer.coefficient": FRICTION}, "test")
    theta = np.cumsum([frame.simulated[1:] for frame in Replay(driven, model).frames(driven.time)], axis=1)
    assert np.std(theta - driven.theta) < 2.0 * NOISE
    theta = np.cumsum(
        [f.simulated[1:] for f in Replay(replace(driven, torques=None), model).frames(driven.time)], axis=1
    )
    assert np.std(theta - driven.theta) > 0.1


def test_a_replay_shows_the_samples_themselves_and_the_error_of_each_joint(trial):
    assert trial.cart is not None
    for frame, theta, cart in zip(Replay(trial, MODEL).frames(trial.time), trial.theta, trial.cart, strict=True):
        assert frame.measured == pytest.approx((cart, theta[0], theta[1] - theta[0]), abs=1e-12)
        assert frame.error == pytest.approx(np.subtract(frame.simulated, frame.measured)[1:], abs=1e-15)
        assert frame.simulated[0] == frame.measured[0]


def test_with_another_model_a_replay_is_that_model_s_from_its_beginning_on(trial):
    replay = Replay(trial, MODEL)
    replay.frames(trial.time[:100])
    replay.take_model(OTHER, trial.time[100])
    shown, expected = replay.frames(trial.time[100:]), Replay(trial, OTHER).frames(trial.time)[100:]
    difference = np.subtract([f.simulated for f in shown], [f.simulated for f in expected])
    assert np.abs(difference).max() < 1e-9


def test_a_free_motion_begins_at_its_start_and_goes_on_from_where_it_is_with_another_model():
    start = Start(inner=2.0, outer=0.3, inner_speed=0.5, outer_speed=-1.0)
    assert start.state.tolist() == [2.0, 2.3, 0.5, -0.5]
    plain = fitted_model(NOMINAL, "test")
    free, times = Free(start, plain), np.arange(400) * 0.005
    first = free.frames(times)
    assert first[0].simulated == pytest.approx((0.0, 2.0, 0.3))
    assert first[0].error is None
    free.take_model(OTHER, 1.0)
    states = simulate(plain.coefficients, start.state, np.array([1.0]))
    expected = simulate(OTHER.coefficients, states[0], times)
    after = np.cumsum([frame.simulated[1:] for frame in free.frames(1.0 + times)], axis=1)
    np.testing.assert_allclose(after, expected[:, :2], rtol=0, atol=1e-6)
    free.restart()
    assert free.frames(times)[0].simulated == pytest.approx((0.0, 2.0, 0.3))


def test_a_motion_that_leaves_all_bounds_is_told():
    wild = fitted_model(NOMINAL | {"c2": 1000.0}, "test")
    with pytest.raises(SimulationError, match="leaves all bounds"):
        Free(Start(), wild).frames(np.arange(2000) * 0.005)
