"""Noise that is remembered, and what is left of a motion."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import time_unit
from cdp_ident.tracing.noise_memory import DECAY, forgets_soon, is_structured
from cdp_ident.trial.trial import Trial

GRAVITY = 9.81


def leaving(filtered, rate, length):
    """A fit that leaves filtered noise: 20 s of a rig of some size, read at some rate."""
    time = np.arange(round(20.0 * rate)) / rate
    windows = cut_into_windows([Trial("any", time, np.column_stack([np.sin(time), np.cos(2.0 * time)]))], 2.0)
    drawn = np.random.default_rng(0).normal(scale=1e-3, size=(len(windows), 400, 2))
    residuals = [filtered(noise)[: len(window.theta)] for noise, window in zip(drawn, windows, strict=True)]
    windows = [
        replace(w, time=w.time[: len(r)], theta=w.theta[: len(r)]) for w, r in zip(windows, residuals, strict=True)
    ]
    model = MotionModel(Mechanism(length, GRAVITY, length, 0.05))
    return Fit(model, np.zeros(5), tuple(windows), tuple(residuals), (), (), 1, 1, True)


def remembered(share):
    return lambda noise: lfilter([1.0], [1.0, -share], noise, axis=0)


@pytest.mark.parametrize(("rate", "length"), [(60.0, 0.05), (200.0, 0.4), (1000.0, 2.0)])
def test_white_noise_is_noise_at_any_rate(rate, length):
    fit = leaving(lambda noise: noise, rate, length)
    assert forgets_soon(fit)
    assert not is_structured(fit)


@pytest.mark.parametrize(("length", "structured"), [(0.05, True), (2.0, False)])
def test_the_rig_says_within_what_time_noise_may_be_forgotten(length, structured):
    share, rate = 0.9, 200.0
    longest = DECAY * time_unit(length, GRAVITY) * rate
    assert (longest < -1.0 / np.log(share)) == structured
    fit = leaving(remembered(share), rate, length)
    assert is_structured(fit) == structured
    assert forgets_soon(fit) != structured


def test_what_is_smooth_is_no_noise_though_it_is_forgotten_as_soon():
    """An error that rods' motion has made is level at lag 0, where that of noise with a memory has a cusp."""
    smooth = leaving(lambda noise: lfilter([1.0], np.poly([0.8, 0.8, 0.6]), noise, axis=0), 200.0, 0.4)
    noise = leaving(remembered(0.9), 200.0, 0.4)
    assert noise.autocorrelation.integrated_time == pytest.approx(smooth.autocorrelation.integrated_time, rel=0.35)
    assert is_structured(smooth)
    assert not is_structured(noise)


def test_what_is_left_over_the_time_that_rods_take_to_move_is_more_than_noise():
    fit = leaving(lambda noise: noise + 1e-3 * np.sin(np.arange(400) / 20.0)[:, None], 200.0, 0.4)
    assert is_structured(fit)
    assert not forgets_soon(fit)
