# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is looked at is what is fitted; of long recordings, pieces that are spread evenly."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.data import prepare
from cdp_ident.fit.roles import PartedTrial
from cdp_ident.fit.scales import scales_of
from cdp_ident.likelihood.recorded import all_recorded, fitted_recorded, states_of
from cdp_ident.likelihood.swing import weights_of_readings
from cdp_ident.trial.trial import Trial
from scenarios.swings import MODEL, TIME, UNIT, measured, motion

NOISE = np.array([2e-4, 3e-4])


@pytest.fixture(scope="module")
def trial():
    return measured(motion(), np.random.default_rng(0))


def data_of(trial, *parted):
    return prepare(parted, 1.0, scales_of([trial], 0.4, 9.81), NOISE)


@pytest.fixture(scope="module")
def with_held_out(trial):
    """Of three stretches and of one."""
    parted = replace(trial, breaks=(600, 1000))
    return data_of(trial, PartedTrial(parted, frozenset([1]), trial), PartedTrial(trial, frozenset([0]), trial))


def test_held_out_stretches_and_trials_are_not_in_what_is_fitted_but_in_all_that_was_measured(with_held_out):
    of, everything = fitted_recorded(with_held_out, 0.2, np.inf), all_recorded(with_held_out, 0.2)
    assert [(swing.trial, swing.begin, len(swing.time)) for swing in of.swings] == [(0, 0.0, 600), (0, 5.0, 600)]
    assert [(swing.trial, len(swing.time)) for swing in everything.swings] == [(0, len(TIME)), (1, len(TIME))]
    for spacing in (0.2, 0.5):  # of nodes, in time units
        (first, *_) = fitted_recorded(with_held_out, spacing, np.inf).swings
        assert first.spacing == pytest.approx(spacing * UNIT, abs=0.5 * with_held_out.scales.step)


def test_the_noise_of_the_outer_encoder_is_what_theta2_has_more_than_theta1(with_held_out):
    of = fitted_recorded(with_held_out, 0.2, np.inf)
    np.testing.assert_allclose(of.encoders, [2e-4, np.sqrt(5.0) * 1e-4])
    less = replace(with_held_out, noise=np.array([2e-4, 2e-4]))
    np.testing.assert_allclose(fitted_recorded(less, 0.2, np.inf).encoders, [2e-4, 0.6e-4])


def test_what_was_averaged_is_noisier_as_it_was_measured(with_held_out):
    averaged = replace(with_held_out, trials=tuple(replace_samples(trial, 4) for trial in with_held_out.trials))
    of = all_recorded(averaged, 0.2)
    np.testing.assert_allclose(of.encoders, 2.0 * fitted_recorded(with_held_out, 0.2, np.inf).encoders, rtol=1e-3)


def replace_samples(trial, together):
    return Trial(trial.name, trial.time[::together], trial.theta[::together])


@pytest.fixture(scope="module")
def long(trial):
    """The same motion many times, as if it went on."""
    repeats = 20
    time = np.arange(repeats * len(TIME)) * 0.005
    repeated = Trial("long", time, np.tile(trial.theta, (repeats, 1)))
    return data_of(trial, PartedTrial(repeated, frozenset(), trial), PartedTrial(trial, frozenset([0]), trial))


def test_a_long_recording_is_looked_at_in_pieces_spread_evenly(long):
    enough = 40.0
    of = fitted_recorded(long, 0.2, enough)
    begins = np.array([swing.begin for swing in of.swings])
    durations = np.array([swing.time[-1] for swing in of.swings])
    assert 0.6 * enough < durations.sum() <= enough
    assert np.all(np.abs(durations - 40.0 * UNIT) < 0.2 * 40.0 * UNIT)
    assert np.all(np.diff(begins) > durations[:-1])
    gaps = np.diff(np.concatenate([[-durations[0]], begins, [160.0]]))
    assert gaps.max() < 2.5 * 160.0 / len(begins)


def test_more_is_looked_at_where_more_is_enough_from_one_piece_to_all_of_it_in_one(long):
    assert len(fitted_recorded(long, 0.2, 0.1).swings) == 1
    few, more = (fitted_recorded(long, 0.2, enough).swings for enough in (40.0, 80.0))
    assert {swing.begin for swing in few} < {swing.begin for swing in more}
    (whole,) = fitted_recorded(long, 0.2, 1000.0).swings
    assert len(whole.time) == 20 * len(TIME)


def test_states_begin_near_the_motion(with_held_out):
    of = fitted_recorded(with_held_out, 0.2, np.inf)
    for swing, states in zip(of.swings, states_of(of, MODEL), strict=True):
        at = swing.begin + swing.node_times
        angles = np.stack([np.interp(at, TIME, angle) for angle in motion().T], axis=1)
        assert states.shape == (len(swing.node_times), 4)
        np.testing.assert_allclose(states[:, :2], angles, atol=0.2)


def test_readings_that_an_encoder_repeats_count_as_one_of_that_encoder():
    inner, outer = np.array([0.1, 0.2, 0.2, 0.2, 0.3]), np.array([0.5, 0.5, 0.6, 0.7, 0.7])
    weight = weights_of_readings(np.column_stack([inner, outer]), (0.0, 0.0))
    third = 1.0 / 3.0
    np.testing.assert_allclose(weight[:, 0], [1.0, third, third, third, 1.0])
    np.testing.assert_allclose(weight[:, 1], [0.5, 0.5, 1.0, 0.5, 0.5])


def test_readings_that_go_to_and_fro_within_a_step_count_as_its_two_sides():
    still, moving = np.array([0.1, 0.2, 0.1, 0.1, 0.2, 0.1]), np.array([0.1, 0.1, 0.2, 0.3, 0.4, 0.4])
    weight = weights_of_readings(np.column_stack([still, moving]), (0.1, 0.1))
    np.testing.assert_allclose(weight[:, 0], 1.0 / 3.0)
    np.testing.assert_allclose(weight[:, 1], [2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0])
