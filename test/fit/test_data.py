"""Which windows are fitted and which are kept out."""

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import prepare
from cdp_ident.fit.scales import scales_of
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.model.simulation import simulate
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5
from scenarios.twin import TEN_SECONDS

THETA = simulate(physical_coefficients(TABLE_5), TABLE_3, TEN_SECONDS)[:, :2]
TRIAL = Trial("whole", TEN_SECONDS, THETA)


def lasting(seconds, trials=1):
    return [lambda time: seconds] * trials


SCALES = scales_of([TRIAL], 0.4, 9.81, np.full(2, 2e-3))


def test_windows_are_shorter_where_a_trial_is_too_short_for_four():
    short = Trial("short", TEN_SECONDS[:800], THETA[:800])
    data = prepare([short], [], lasting(2.5), SCALES)
    assert len(data.fit) == 3
    assert len(data.holdout) == 1
    assert data.fit[0].duration == pytest.approx(1.0, abs=0.02)


def test_with_trials_to_judge_by_all_windows_of_the_others_are_fitted():
    data = prepare([TRIAL, TRIAL], [TRIAL], lasting(2.5, 3), SCALES)
    assert len(data.fit) == 8
    assert {window.trial for window in data.holdout} == {2}
    assert data.held_out == 1


def test_the_window_the_step_and_the_half_width_are_the_rig_s():
    data = prepare([TRIAL], [], lasting(SCALES.window), SCALES)
    assert data.window == pytest.approx(SCALES.window, rel=1e-3)  # the trial is a sample too short for four
    assert data.scales is SCALES
    assert {window.grid.step for window in (*data.fit, *data.holdout)} == {SCALES.step}
    assert {window.half_width for window in (*data.fit, *data.holdout)} == {SCALES.half_width}


@pytest.mark.parametrize("first", [0, 1, 2])
def test_every_fourth_window_is_kept_out_from_the_first_one_on(first):
    data = prepare([TRIAL, TRIAL], [], lasting(1.25, 2), SCALES, first)
    begins = sorted({window.begin for window in (*data.fit, *data.holdout)})
    kept_out = [begins.index(window.begin) for window in data.holdout if window.trial == 0]
    assert kept_out == list(range(first, 8, 4))


@pytest.mark.parametrize(
    ("fit", "holdout", "message"),
    [
        ([], [], "there is no trial to fit: give at least one bag"),
        ([(0, 21)], [], "the trials hold 0.1 s of motion; with this rig's L and sampling at least 0.4 s are needed"),
        ([(0, 2000)], [(0, 6)], "too few samples to fit and to judge by: record longer ones"),
    ],
)
def test_trials_that_do_not_suffice_are_refused(fit, holdout, message):
    def cut(first, last):
        return Trial("cut", TEN_SECONDS[first:last], THETA[first:last])

    with pytest.raises(IdentificationError) as caught:
        prepare(
            [cut(*each) for each in fit],
            [cut(*each) for each in holdout],
            lasting(2.5, len(fit) + len(holdout)),
            SCALES,
        )
    assert message in str(caught.value)
