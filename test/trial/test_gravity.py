# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where gravity pulls, by the motion."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.trial.gravity import gravity_of, in_right_ranges
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.options import TrialOptions


@pytest.fixture(scope="module")
def samples(recordings):
    made = recordings().carry(2.0, 2.5, 1.0).swing(5)
    return Samples(made.stamps(), made.joints(), None)


def test_zeros_that_are_off_show_in_gravity_s_direction(samples):
    assert gravity_of(samples, TrialOptions()) == pytest.approx([0.0, 0.0], abs=0.01)
    turned = replace(samples, angles=samples.angles - [0.7, -1.9])
    assert gravity_of(turned, TrialOptions()) == pytest.approx([0.7, 0.7 - 1.9], abs=0.02)


@pytest.mark.parametrize(
    "settings", [{}, {"inner_sign": -1}, {"outer_sign": -1, "zero": "hanging"}, {"outer_unit": "degrees"}]
)
@pytest.mark.parametrize("sizes", [(0.2, 0.2), (0.8, 0.0), (0.0, 3.2), (51.5, 51.5)])
def test_a_counter_begins_in_the_range_in_which_gravity_pulls_down_however_the_swing_ends(samples, sizes, settings):
    options = TrialOptions(**settings)
    inner = options.inner_sign * (samples.angles[:, 0] - (np.pi if options.zero == "hanging" else 0.0))
    unit = 180 / np.pi if options.outer_unit == "degrees" else 1.0
    right = np.column_stack([inner, unit * options.outer_sign * samples.angles[:, 1]])
    ranges = (sizes[0], unit * sizes[1])
    lost = right - np.array([3 if sizes[0] < 1 else 1, -1]) * ranges
    found = in_right_ranges(replace(samples, angles=lost, ranges=ranges), options)
    assert found.angles == pytest.approx(right, abs=1e-9)


def test_rods_that_hardly_move_leave_a_counter_as_it_is(samples):
    still = replace(samples, angles=np.zeros_like(samples.angles), ranges=(0.2, 0.2))
    assert in_right_ranges(still, TrialOptions()) is still
