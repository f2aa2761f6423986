# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Windows in which effects are looked for are spread evenly over all trials, whatever repeats in them."""

import numpy as np
import pytest

from cdp_ident.fit.share import share_of
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.trial.trial import Trial

TRIALS, WINDOWS, WINDOW = 60, 34, 1.0


@pytest.fixture(scope="module")
def windows():
    time = np.arange(round(20 * WINDOWS * WINDOW) + 1) / 20.0
    trial = Trial("swing", time, np.column_stack([np.sin(time), np.cos(time)]))
    return cut_into_windows([trial] * TRIALS, WINDOW)


def test_all_are_taken_where_there_is_no_more_motion_than_enough(windows):
    few = [window.duration for window in windows[:10]]
    assert share_of(few, sum(few)) == tuple(range(10))
    assert share_of(few, np.inf) == tuple(range(10))


@pytest.mark.parametrize("enough", [60.0, 200.0])
def test_a_share_holds_as_much_motion_as_was_asked_for(windows, enough):
    chosen = share_of([window.duration for window in windows], enough)
    assert sum(windows[index].duration for index in chosen) == pytest.approx(enough, abs=2 * WINDOW)
    assert list(chosen) == sorted(set(chosen))


def test_every_trial_and_every_part_of_a_trial_has_its_share(windows):
    chosen = share_of([window.duration for window in windows], 200.0)
    of_trial = np.bincount([windows[index].trial for index in chosen], minlength=TRIALS)
    assert of_trial.min() >= 2
    assert of_trial.max() <= 5
    of_part = np.bincount([int(4 * (index % WINDOWS) / WINDOWS) for index in chosen], minlength=4)
    assert of_part.min() > 0.7 * of_part.mean()


def test_at_least_one_is_taken():
    assert len(share_of([1.0] * 10, 0.1)) == 1
