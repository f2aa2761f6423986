# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can be shown, and that a motion asked for piece by piece is the one that is asked for at once."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.diagnosis.evaluation import free_run
from cdp_ident.errors import SimulationError
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.model.weights import Weight
from cdp_ident.replay.scene import Free, MotionStream, Replay, Start
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5
from reference.weights import with_weight
from scenarios.driven import FRICTION, NOISE, driven_by_motors

ROOT = Path(__file__).parents[2]
BAG = ROOT / "bags/swing_check"
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


def test_the_library_s_example_runs(tmp_path):
    (tmp_path / "fitted.yaml").write_text(parameter_file(NOMINAL))
    found = re.search(r"```python\n(.*?)```", (ROOT / "docs/reference/simulator.md").read_text(), re.DOTALL)
    assert found
    code = found[1].replace("identification/swing_wide", str(tmp_path))
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False, capture_output=True, text=True)
    assert 0.0 < float(done.stdout) < 100.0, done.stderr


START = np.array([2.5, 2.0, 0.0, 1.0])
TIMES = np.arange(2001) * 0.005
EFFECTS = {
    "effects.coulomb_friction.outer.torque": 0.001,
    "effects.encoder_offset.inner.offset": 0.02,
    "effects.time_offset.outer.delay": 0.013,
    "effects.impulse.inner.impulse": 0.02,
    "effects.impulse.inner.time": 3.0,
    "effects.impulse.inner.trial": "swing",
}
WITH_EFFECTS = fitted_model(NOMINAL | EFFECTS, "test")


def whole(model, cart=None, times=TIMES):
    """Return what the library itself makes of the whole time as a window of a trial."""
    (window,) = cut_into_windows([Trial("swing", times, np.zeros((len(times), 2)), cart)], np.inf)
    return model.motion.predict(model.values, START, replace(window, trial=model.trial("swing")))


def in_pieces(stream, times, cuts):
    return np.concatenate([stream.readings(piece) for piece in np.split(times, sorted(set(cuts)))])


@given(st.lists(st.integers(1, 2000), max_size=30))
def test_however_it_is_cut_it_is_one_simulation_with_effects_of_torques_and_encoders(cuts):
    stream = MotionStream(WITH_EFFECTS, START, WITH_EFFECTS.trial("swing"))
    np.testing.assert_allclose(in_pieces(stream, TIMES, cuts), whole(WITH_EFFECTS), rtol=0, atol=1e-9)


@pytest.mark.parametrize("delay", [-0.03, 0.03])
def test_an_encoder_that_is_early_or_late_is_so_across_pieces(delay):
    model = fitted_model(NOMINAL | EFFECTS | {"effects.time_offset.outer.delay": delay}, "test")
    stream = MotionStream(model, START, model.trial("swing"))
    expected = whole(model, times=np.append(TIMES, TIMES[-1] + 0.01 * np.arange(1, 6)))[: len(TIMES)]
    np.testing.assert_allclose(in_pieces(stream, TIMES, range(1, 2001)), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("every", [1, 40])
def test_an_encoder_with_play_goes_on_across_pieces_and_past_times_that_nobody_asked_for(every):
    model = fitted_model(NOMINAL | EFFECTS | {"effects.backlash.outer.gap": 0.1}, "test")
    (window,) = cut_into_windows([Trial("swing", TIMES, np.zeros((len(TIMES), 2)))], np.inf)
    window = replace(window, trial=model.trial("swing"), theta=np.empty((0, 2)))
    at_once = model.motion.predict(model.values, START, window)
    stream = MotionStream(model, START, model.trial("swing"))
    pieces = np.concatenate([stream.readings(time) for time in TIMES[::every, None]])
    np.testing.assert_allclose(pieces, at_once[::every], rtol=0, atol=1e-9)


def test_the_cart_s_acceleration_is_that_of_the_trial():
    cart = 0.05 * np.sin(2.0 * TIMES)
    window = cut_into_windows([Trial("swing", TIMES, np.zeros((len(TIMES), 2)), cart)], np.inf)[0]
    # Linear between the samples, of which every other half step is one.
    stream = MotionStream(WITH_EFFECTS, START, WITH_EFFECTS.trial("swing"), (window.grid.half_step_times(), window.u))
    expected = whole(WITH_EFFECTS, cart)
    np.testing.assert_allclose(in_pieces(stream, TIMES, range(7, 2001, 7)), expected, rtol=0, atol=1e-9)
    assert not np.allclose(expected, whole(WITH_EFFECTS), atol=0.01)


def test_times_between_the_integrator_s_steps_are_as_good():
    model = fitted_model(NOMINAL, "test")
    times = np.arange(3000) / 300.0
    expected = simulate(model.coefficients, START, times)[:, :2]
    np.testing.assert_allclose(in_pieces(MotionStream(model, START), times, range(1, 3000, 11)), expected, atol=1e-9)


def test_its_state_is_the_one_to_go_on_from():
    model = fitted_model(NOMINAL, "test")
    stream = MotionStream(model, START)
    stream.readings(np.arange(4.0, 5.0, 0.005))
    after = MotionStream(model, stream.state(4.5))
    np.testing.assert_allclose(after.readings(TIMES[:200]), stream.readings(4.5 + TIMES[:200]), rtol=0, atol=1e-6)
    assert stream.state(4.5) == pytest.approx(simulate(model.coefficients, START, np.array([4.5]))[0], abs=1e-9)


def test_what_happened_once_happens_in_its_trial_only():
    with_impulse, without = (
        MotionStream(WITH_EFFECTS, START, WITH_EFFECTS.trial("swing")),
        MotionStream(WITH_EFFECTS, START),
    )
    shown, alone = with_impulse.readings(TIMES), without.readings(TIMES)
    assert np.array_equal(shown[:580], alone[:580])
    assert np.ptp(shown[620:] - alone[620:]) > 0.1
