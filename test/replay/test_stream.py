# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A motion asked for piece by piece is the one that is asked for at once."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.replay.stream import MotionStream
from cdp_ident.trial.trial import Trial

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
MODEL = fitted_model(NOMINAL | EFFECTS, "test")


def whole(model, cart=None, times=TIMES):
    """Return what the library itself makes of the whole time as a window of a trial."""
    (window,) = cut_into_windows([Trial("swing", times, np.zeros((len(times), 2)), cart)], np.inf)
    return model.motion.predict(model.values, START, replace(window, trial=model.trial("swing")))


def in_pieces(stream, times, cuts):
    return np.concatenate([stream.readings(piece) for piece in np.split(times, sorted(set(cuts)))])


@given(st.lists(st.integers(1, 2000), max_size=30))
def test_however_it_is_cut_it_is_one_simulation_with_effects_of_torques_and_encoders(cuts):
    stream = MotionStream(MODEL, START, MODEL.trial("swing"))
    np.testing.assert_allclose(in_pieces(stream, TIMES, cuts), whole(MODEL), rtol=0, atol=1e-9)


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
    stream = MotionStream(MODEL, START, MODEL.trial("swing"), (window.grid.half_step_times(), window.u))
    expected = whole(MODEL, cart)
    np.testing.assert_allclose(in_pieces(stream, TIMES, range(7, 2001, 7)), expected, rtol=0, atol=1e-9)
    assert not np.allclose(expected, whole(MODEL), atol=0.01)


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
    with_impulse, without = MotionStream(MODEL, START, MODEL.trial("swing")), MotionStream(MODEL, START)
    shown, alone = with_impulse.readings(TIMES), without.readings(TIMES)
    assert np.array_equal(shown[:580], alone[:580])
    assert np.ptp(shown[620:] - alone[620:]) > 0.1
