"""What remains is told from noise by its size and by how long it is correlated."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.noise import noise_of
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.unexplained import unexplained
from reference.pendulum import TABLE_5
from scenarios.twin import twin

RATE = 500.0


def remaining(trial):
    model = MotionModel(Mechanism.of(Prior()))
    values = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
    windows = cut_into_windows([trial], 1.25)
    fit = refine(model, values, windows)
    found = unexplained(FinalModel(fit, fit), noise_of(trial), ["twin"], 1.0)
    return found, float(np.max([fit.rmse(k) for k in range(2)] / noise_of(trial)))


@pytest.fixture(scope="module")
def clean():
    times = np.arange(int(8.0 * RATE)) / RATE
    return twin(np.random.default_rng(0), times=times, noise=0.0, counts_per_turn=None, tolerance=1e-8)


def test_noise_with_a_memory_is_noise(clean):
    white = np.random.default_rng(1).normal(scale=5e-4, size=clean.theta.shape)
    found, ratio = remaining(replace(clean, theta=clean.theta + lfilter([1.0], [1.0, -0.7], white, axis=0)))
    assert ratio > 1.3
    assert not found.significant
    assert re.fullmatch(r"nothing but the encoders' noise, correlated over [3-7] samples", found.description)


def test_what_is_correlated_as_long_as_the_rods_take_to_move_remains(clean):
    white = np.random.default_rng(1).normal(scale=5e-4, size=clean.theta.shape)
    ripple = 1e-3 * np.sin(3.0 * np.diff(clean.theta, axis=1, prepend=0.0))
    found, ratio = remaining(replace(clean, theta=clean.theta + white + ripple))
    assert ratio > 1.3
    assert found.significant


def test_a_vibration_that_lasts_remains(clean):
    white = np.random.default_rng(1).normal(scale=5e-4, size=clean.theta.shape)
    vibration = 1e-3 * np.sin(2.0 * np.pi * 40.0 * clean.time)[:, None]
    found, ratio = remaining(replace(clean, theta=clean.theta + white + vibration))
    assert ratio > 1.3
    assert found.significant
