# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials cut into windows, each with its role."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import prepare
from cdp_ident.fit.roles import PartedTrial
from cdp_ident.fit.scales import scales_of
from cdp_ident.trial.trial import Trial
from scenarios.twin import TEN_SECONDS, standard_motion

THETA = standard_motion()
TRIAL = Trial("whole", TEN_SECONDS, THETA)


NOISE = np.full(2, 2e-3)
SCALES = scales_of([TRIAL], 0.4, 9.81)


def whole(*trials):
    return [PartedTrial(trial, frozenset(), trial) for trial in trials]


HELD_OUT = PartedTrial(TRIAL, frozenset([0]), TRIAL)


def test_windows_are_shorter_where_a_trial_is_too_short_for_four():
    short = Trial("short", TEN_SECONDS[:800], THETA[:800])
    data = prepare([*whole(short), HELD_OUT], 2.5, SCALES, NOISE)
    assert len(data.fit) == 4
    assert data.fit[0].duration == pytest.approx(1.0, abs=0.02)


def test_every_window_of_what_is_held_out_and_no_other_is_held_out():
    parted = PartedTrial(replace(TRIAL, breaks=(1000, 1400)), frozenset([1]), TRIAL)
    data = prepare([parted, HELD_OUT], 1.0, SCALES, NOISE)
    places = {(window.trial, window.first) for window in data.holdout}
    assert places == {(0, 1000), (0, 1200), *((1, first) for first in range(0, 2000, 200))}
    assert all(window.trial == 0 for window in data.fit)


def test_the_window_and_the_step_are_the_rig_s():
    data = prepare([*whole(TRIAL), HELD_OUT], SCALES.window, SCALES, NOISE)
    assert data.window == pytest.approx(SCALES.window, rel=3e-3)  # the trial is a sample too short for four
    assert data.scales is SCALES
    assert data.noise is NOISE
    assert {window.grid.step for window in (*data.fit, *data.holdout)} == {SCALES.step}


@pytest.mark.parametrize(
    ("fit", "holdout", "message"),
    [
        ([(0, 21)], [(0, 2000)], "too few samples to fit and to evaluate the fit: record longer ones"),
        ([(0, 2000)], [(0, 6)], "too few samples to fit and to evaluate the fit: record longer ones"),
    ],
)
def test_trials_that_do_not_suffice_are_refused(fit, holdout, message):
    def cut(first, last):
        return Trial("cut", TEN_SECONDS[first:last], THETA[first:last])

    with pytest.raises(IdentificationError) as caught:
        prepare(
            [
                *whole(*(cut(*each) for each in fit)),
                *(PartedTrial(cut(*each), frozenset([0]), cut(*each)) for each in holdout),
            ],
            2.5,
            SCALES,
            NOISE,
        )
    assert message in str(caught.value)


def test_shorter_windows_hold_the_same_samples_and_no_fewer_than_determine_an_initial_state():
    data = prepare([*whole(TRIAL), HELD_OUT], 2.5, SCALES, NOISE)
    for longest, fewest in ((1.0, 160), (1e-3, 12)):
        shorter = data.over_shorter_windows(longest)
        for before, after in ((data.fit, shorter.fit), (data.holdout, shorter.holdout)):
            samples = [np.concatenate([np.arange(w.first, w.samples.stop) for w in of]) for of in (before, after)]
            assert np.array_equal(*samples)
            assert min(len(window.theta) for window in after) >= fewest
        assert shorter.window <= max(longest, 0.1)
