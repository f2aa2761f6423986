# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Counts per turn that are taken wrongly are told from the motion, with the factor that puts them right."""

import re

import numpy as np
import pytest

from cdp_ident.errors import TrialError
from cdp_ident.trial.find import find_trial
from cdp_ident.trial.joints import Samples, model_angles
from cdp_ident.trial.options import TrialOptions


@pytest.fixture(scope="module")
def samples(recordings):
    made = recordings().carry(2.0, 2.5, 1.0).hold(0.5).swing(10)
    return Samples(made.stamps(), made.joints(), None)


def read_as(samples, inner, outer):
    """What encoders show whose counts per turn are wrong, and that are right where the rods hang."""
    hanging = np.array([np.pi, 0.0])
    return Samples(samples.stamps, hanging + (samples.angles - hanging) * np.array([inner, outer]), None)


@pytest.mark.parametrize(
    ("factors", "settings"),
    [
        ({"inner": 4.0}, r"the inner joint's readings are (\S+) times the angle: inner_scale: \1 leaves"),
        ({"outer": 0.5}, r"the outer joint's readings are (\S+) times the angle: outer_scale: \1 leaves"),
        (
            {"inner": 0.25, "outer": 0.25},
            r"the readings of both joints are (\S+) times the angle: inner_scale: \1 and outer_scale: \1 leaves",
        ),
    ],
)
def test_counts_that_are_wrong_are_refused_with_the_factor(samples, factors, settings):
    wrong = read_as(samples, factors.get("inner", 1.0), factors.get("outer", 1.0))
    with pytest.raises(TrialError, match=f"{settings}.*check the counts per turn, or set that") as refused:
        find_trial(wrong, TrialOptions())
    assert float(re.search(settings, str(refused.value))[1]) == next(iter(factors.values()))


def test_readings_that_are_right_at_zero_are_told_from_those_that_are_right_where_the_rods_hang(samples):
    wrong = Samples(samples.stamps, samples.angles * np.array([4.0, 1.0]), None)
    with pytest.raises(TrialError, match="inner_scale: 4 and scale_from: zero leaves"):
        find_trial(wrong, TrialOptions())
    mended = find_trial(wrong, TrialOptions(inner_scale=4.0, scale_from="zero"))
    assert mended.trial.theta == pytest.approx(find_trial(samples, TrialOptions()).trial.theta, abs=1e-9)


@pytest.mark.parametrize("joints", [(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])
def test_turns_are_told(samples, joints):
    wrong = Samples(samples.stamps, samples.angles / (2 * np.pi) ** np.array(joints), None)
    with pytest.raises(TrialError, match=r"0\.1592 times the angle \(turns\?\)"):
        find_trial(wrong, TrialOptions())


@pytest.mark.parametrize("per_radian", [4096 / (2 * np.pi), 18000 / np.pi])
def test_readings_that_turn_too_far_are_in_another_unit(samples, per_radian):
    set_right = TrialOptions(inner_scale=per_radian, outer_scale=per_radian, scale_from="zero")
    counted = find_trial(Samples(samples.stamps, np.round(samples.angles * per_radian), None), set_right).trial
    angles = model_angles(samples.angles, TrialOptions())[round(counted.start * 200) :]
    assert counted.theta == pytest.approx(angles[: len(counted.time)], abs=0.01)
    for factors in ((per_radian, 1.0), (1.0, per_radian), (per_radian, per_radian)):
        counts = np.round(samples.angles * np.array(factors))
        with pytest.raises(TrialError, match="quarter of a turn from sample to sample: its readings are no radians"):
            find_trial(Samples(samples.stamps, counts, None), TrialOptions())


def test_any_other_factor_is_found_too(samples):
    with pytest.raises(TrialError, match=r"outer_scale: (0\.29\d+|0\.3|0\.30\d+) leaves"):
        find_trial(read_as(samples, 1.0, 0.3), TrialOptions())


def test_the_factor_that_the_refusal_names_puts_the_angles_right(samples):
    right = find_trial(samples, TrialOptions())
    mended = find_trial(read_as(samples, 1.0, 0.5), TrialOptions(outer_scale=0.5))
    assert mended.warnings == right.warnings == ()
    assert mended.trial.theta == pytest.approx(right.trial.theta, abs=1e-9)


def test_factors_multiply_those_that_are_set_already(samples):
    with pytest.raises(TrialError, match=r"outer_scale: (0\.5|0\.49\d+|0\.50\d+) leaves"):
        find_trial(read_as(samples, 1.0, 0.5), TrialOptions(outer_scale=2.0))
