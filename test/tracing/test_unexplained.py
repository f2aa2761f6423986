"""What remains is told from noise by its size and by how long it is correlated."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.noise import noise_of
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import fit_initial_states, refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.unexplained import unexplained
from reference.pendulum import TABLE_5
from scenarios.twin import twin

RATE = 500.0


def held_out(added):
    """What is said to remain where held-out motion is followed with values off by 0.08 % of A33, beside 0.5 mrad."""
    rng = np.random.default_rng(1)
    model = MotionModel(Mechanism.of(Prior()))
    values = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
    fitted, other = (twin(rng, noise=5e-4, counts_per_turn=None) for _ in range(2))
    fit = refine(model, values, cut_into_windows([fitted], 1.25))
    off = fit.values * [1.0, 1.0008, 1.0, 1.0, 1.0]
    held = fit_initial_states(model, off, cut_into_windows([other], 1.25))
    spread = np.zeros((len(values), len(values)))
    spread[1, 1] = (added * off[1]) ** 2
    return unexplained(FinalModel(fit, held), noise_of(fitted), ["twin"], 1.0, spread)


def test_what_uncertain_values_move_held_out_motion_by_is_no_remainder():
    assert held_out(0.0).significant
    allowed = held_out(0.0008)
    assert not allowed.significant
    assert allowed.description.endswith("what the values' uncertainty moves the held-out motion by")


def remaining(trial):
    model = MotionModel(Mechanism.of(Prior()))
    values = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
    windows = cut_into_windows([trial], 1.25)
    fit = refine(model, values, windows)
    found = unexplained(FinalModel(fit, fit), noise_of(trial), ["twin"], 1.0, np.zeros((len(values), len(values))))
    return found, float(np.max([fit.rmse(k) for k in range(2)] / noise_of(trial)))


@pytest.fixture(scope="module")
def clean():
    times = np.arange(int(8.0 * RATE)) / RATE
    return twin(np.random.default_rng(0), times=times, noise=0.0, counts_per_turn=None, tolerance=1e-8)


def test_noise_with_a_memory_is_noise(clean):
    white = np.random.default_rng(1).normal(scale=5e-4, size=clean.theta.shape)
    found, ratio = remaining(replace(clean, theta=clean.theta + lfilter([1.0], [1.0, -0.7], white, axis=0)))
    assert ratio < 1.2
    assert not found.significant
    assert found.description == "nothing but the encoders' noise"


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
