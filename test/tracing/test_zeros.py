"""Encoders whose zeros are taken anew for each trial."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import fit_initial_states, refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.tracing.torque_residual import corrected, torque_residual
from cdp_ident.tracing.zeros import (
    drop_superfluous_zeros,
    fit_zeros_by_trial,
    fit_zeros_by_trial_again,
    largest_zeros,
)
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, twin

TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
MODEL = MotionModel(Mechanism.of(Prior()))
STARTS = ((2.2, 2.6, 0.0, 0.0), (2.0, 2.9, 0.0, 0.0), (2.5, 2.1, 0.0, 0.0))
NOISE = 5e-4
ZEROS = np.array([[0.02, -0.03], [-0.01, 0.05], [0.03, 0.01]])
"""Of the inner and the outer encoder in each trial [rad]."""


@pytest.fixture(scope="module")
def trials():
    times = TEN_SECONDS[:1200]
    rngs = map(np.random.default_rng, range(len(STARTS)))
    return [twin(rng, start=s, times=times, noise=NOISE, tolerance=1e-8) for rng, s in zip(rngs, STARTS, strict=True)]


def windows_of(trials, zeros):
    off = [replace(trial, theta=trial.theta + np.cumsum(zero)) for trial, zero in zip(trials, zeros, strict=True)]
    return cut_into_windows(off, 1.5)


def progress_of(trials, zeros, steps=(0.0, 0.0)):
    """Begin with the last trial held out."""
    fit = refine(MODEL, TRUTH, [window for window in windows_of(trials, zeros) if window.trial < 2])
    folds = tuple(tuple(range(first, len(fit.windows), 4)) for first in range(4))
    return Progress(attempt_of(fit, folds), NOISE, encoder_steps=np.array(steps))


def held_out(fit, trials, zeros):
    return fit_initial_states(fit.model, fit.values, [w for w in windows_of(trials, zeros) if w.trial == 2])


def test_zeros_of_each_trial_are_found_those_of_a_trial_held_out_among_them(trials):
    progress = progress_of(trials, ZEROS)
    fit_zeros_by_trial(progress)
    fit = progress.current.fit
    holdout = held_out(fit, trials, ZEROS)
    assert fit.model.zeros == (0, 1)
    assert [fit.values[fit.model.zero_places(k)] for k in range(2)] == pytest.approx(ZEROS[:2], abs=2e-4)
    assert holdout.values[holdout.model.zero_places(2)] == pytest.approx(ZEROS[2], abs=2e-4)
    assert fit.values[fit.model.of_rig] == pytest.approx(TRUTH, rel=0.01)
    assert np.array_equal(holdout.values[holdout.model.of_rig], fit.values[fit.model.of_rig])
    assert max(fit.rmse(), holdout.rmse()) < 1.3 * NOISE  # its counts add to it
    assert largest_zeros(progress.current) == pytest.approx([0.02, 0.05], abs=2e-4)


def test_zeros_are_found_where_each_trial_is_a_fold(trials):
    fit = refine(MODEL, TRUTH, windows_of(trials, ZEROS))
    folds = tuple(tuple(k for k, window in enumerate(fit.windows) if window.trial == trial) for trial in range(3))
    progress = Progress(attempt_of(fit, folds), NOISE)
    fit_zeros_by_trial(progress)
    assert progress.current.model.zeros == (0, 1, 2)
    assert progress.current.validation.rmse() < 1.3 * NOISE


def test_an_offset_that_is_the_same_in_all_trials_yields_to_zeros_of_each_and_is_asked_for_nowhere_else(trials):
    progress = progress_of(trials, ZEROS)
    fit_zeros_by_trial_again(progress)
    assert progress.current.model.zeros == ()
    offset = next(effect for effect in CATALOGUE if effect.key == "encoder_offset.outer")
    model = MODEL.with_effect(ActiveEffect(offset))
    fit = refine(model, np.append(TRUTH, 0.0), progress.current.fit.windows)
    progress = Progress(attempt_of(fit, progress.current.folds), NOISE)
    fit_zeros_by_trial_again(progress)
    assert progress.current.model.effects == ()
    assert largest_zeros(progress.current) == pytest.approx([0.02, 0.05], abs=2e-4)


def test_zeros_that_took_the_part_of_another_effect_are_right_again_once_it_is_there(trials):
    progress = progress_of(trials, ZEROS)
    fit_zeros_by_trial(progress)
    drop_superfluous_zeros(progress)
    assert progress.current.model.zeros == (0, 1)
    true = windows_of(trials, np.zeros((3, 2)))
    fit = refine(progress.current.model, progress.current.fit.values, [window for window in true if window.trial < 2])
    progress.current = attempt_of(fit, progress.current.folds)
    drop_superfluous_zeros(progress)
    assert progress.current.model.zeros == ()
    assert progress.current.fit.values == pytest.approx(TRUTH, rel=0.01)
    assert progress.steps[-1].action == "dropped zeros by trial"


@pytest.mark.parametrize("zeros", [np.zeros((3, 2)), np.tile([0.01, -0.02], (3, 1))])
def test_zeros_that_are_right_or_off_by_the_same_in_all_trials_are_left_to_the_effects(trials, zeros):
    progress = progress_of(trials, zeros)
    fit_zeros_by_trial(progress)
    assert progress.current.model.zeros == ()


def test_a_model_with_more_effects_keeps_the_zeros(trials):
    progress = progress_of(trials, ZEROS)
    fit_zeros_by_trial(progress)
    model = progress.current.model
    spring = next(e for e in CATALOGUE if e.key == "joint_spring.inner")
    sprung = model.with_effect(ActiveEffect(spring))
    assert sprung.names == (*model.names, "joint_spring.inner.stiffness", "joint_spring.inner.torque")
    assert sprung.without_effect(0)[0] == model
    values = np.concatenate([progress.current.fit.values, [0.3, 0.1]])
    assert values[sprung.places(0)].tolist() == [0.3, 0.1]


def test_zeros_that_differ_by_less_than_a_step_of_the_encoders_are_rounding(trials):
    progress = progress_of(trials, 0.05 * ZEROS, steps=(0.003, 0.006))
    fit_zeros_by_trial(progress)
    assert progress.current.model.zeros == ()
    finer = progress_of(trials, 0.05 * ZEROS)
    fit_zeros_by_trial(finer)
    assert finer.current.model.zeros == (0, 1)


def test_the_rods_angles_and_the_torques_that_are_missing_are_free_of_the_zeros(trials):
    progress = progress_of(trials, ZEROS)
    fit_zeros_by_trial(progress)
    for fit in (progress.current.fit, held_out(progress.current.fit, trials, ZEROS)):
        for window, shown in zip(corrected(fit).windows, fit.windows, strict=True):
            off = (shown.theta - window.theta)[0]
            assert off == pytest.approx(np.cumsum(ZEROS[window.trial]), abs=4e-4)
        with_zeros, without = (np.std(torque_residual(f).torque) for f in (fit, corrected(fit)))
        assert without < 0.9 * with_zeros
