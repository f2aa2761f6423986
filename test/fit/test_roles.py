# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is fitted and what is held out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.fit.roles import assign_roles
from cdp_ident.trial.trial import Trial

UNIT = 0.2


def trial(seconds=30.0, breaks=(), rate=100.0):
    time = np.arange(round(seconds * rate)) / rate
    return Trial("swing", time, np.column_stack([np.sin(time), np.cos(time)]), breaks=breaks)


def held_out_times(parted):
    bounds = parted.trial.bounds
    return np.concatenate([parted.trial.time[slice(*bounds[index])] for index in sorted(parted.held_out)])


def test_trials_to_hold_out_are_held_out_whole_and_the_others_are_shown_whole():
    fit, holdout = assign_roles([trial()], [trial(breaks=(1000,))], UNIT)
    assert np.array_equal(fit.shown.time, fit.trial.time)
    assert holdout.held_out == {0, 1}


def test_without_any_a_sixth_of_each_trial_is_held_out_in_pieces_of_the_rig_s_time():
    (parted,) = assign_roles([trial(seconds=48.0)], [], UNIT)
    times = held_out_times(parted)
    assert len(times) == pytest.approx(len(parted.trial.time) / 6, abs=3)
    begins = times[np.flatnonzero(np.diff(times, prepend=-1.0) > 0.02)]
    assert begins == pytest.approx(4.8 + 9.6 * np.arange(5), abs=0.02)


@given(seconds=st.floats(2.0, 40.0), breaks=st.sets(st.integers(1, 150), max_size=3))
def test_every_sample_is_shown_or_held_out_and_none_is_both(seconds, breaks):
    whole = trial(seconds, tuple(sorted(breaks)))
    (parted,) = assign_roles([whole], [], UNIT)
    held_out = held_out_times(parted)
    assert np.array_equal(np.sort(np.concatenate([parted.shown.time, held_out])), whole.time)
    assert {*whole.breaks} <= {*parted.trial.breaks}
    assert np.all(np.diff(parted.shown.time)[[at - 1 for at in parted.shown.breaks]] > 0)
    assert np.array_equal(parted.trial.theta, whole.theta)
