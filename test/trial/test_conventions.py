# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import re

import numpy as np
import pytest

from cdp_ident.errors import TrialError
from cdp_ident.trial.balance import motion_on_grid
from cdp_ident.trial.conventions import check_conventions
from cdp_ident.trial.find import find_trial
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.meaning import Recorded
from cdp_ident.trial.options import UNITS, TrialOptions
from cdp_ident.trial.zero_input import moving_windows


def check(made, change=lambda joints: joints, **options):
    options = TrialOptions(**options)
    joints = change(made.joints())
    motion = motion_on_grid(np.arange(len(joints)) / made.rate, joints, None)
    return check_conventions(Recorded((), (motion,), (moving_windows(motion, options),)), options)


@pytest.fixture
def swing(recording):
    return recording().carry(2.0, 2.5, 1.0).hold(0.5).swing(10)


def test_right_conventions_pass_without_a_word(swing):
    balance, warnings = check(swing)
    assert warnings == []
    assert balance.lumped.is_mechanism
    assert balance.lumped.unexplained < 0.01


def test_the_refusal_names_everything_that_would_have_to_be_set(swing):
    def absolute_hanging(joints):
        return np.column_stack([joints[:, 0], joints.sum(axis=1)]) - np.pi

    with pytest.raises(TrialError, match=r"outer_angle: absolute and zero: hanging leaves 0\.\d%"):
        check(swing, absolute_hanging)


def test_an_absolute_angle_whose_zero_is_another_one_is_refused_too(swing):
    def absolute_outer_hanging(joints):
        return np.column_stack([joints[:, 0], joints.sum(axis=1) - np.pi])

    with pytest.raises(
        TrialError, match=r"outer_angle: absolute and the outer joint's zero half a turn on leaves 0\.\d%"
    ):
        check(swing, absolute_outer_hanging)


def test_the_refusal_carries_its_evidence(swing):
    with pytest.raises(TrialError, match=r"gravity terms of the rods -\d+\.\d and -\d+\.\d 1/s\^2"):
        check(swing, zero="hanging")


def test_the_inner_zero_alone_half_a_turn_off_is_told_from_the_outer_s(swing):
    with pytest.raises(TrialError, match="the zero of the inner joint is half a turn"):
        check(swing, lambda joints: joints + np.array([np.pi, -np.pi]))


@pytest.mark.parametrize(("inner", "outer"), [(0.7, 0.0), (-2.4, 2.9)])
def test_zeros_that_are_anywhere_are_named_with_the_offsets_that_put_them_right(swing, inner, outer):
    def moved(joints):
        return joints - np.array([inner, outer])

    with pytest.raises(TrialError, match="zeros are elsewhere: ") as refused:
        check(swing, moved)
    named = dict(re.findall(r"(inner_offset|outer_offset): (\S+)", str(refused.value)))
    offsets = {name: float(value) for name, value in named.items()}
    assert [offsets.get("inner_offset", 0.0), offsets.get("outer_offset", 0.0)] == pytest.approx(
        [inner, outer], abs=2e-2
    )
    assert check(swing, moved, **offsets)[1] == []


def test_without_motion_nothing_can_be_said_and_that_is_said(recording):
    balance, warnings = check(recording().hold(10))
    assert balance is None
    assert "too little motion" in warnings[0]


def test_an_outer_rod_that_is_locked_is_no_double_pendulum(recording):
    made = recording().carry(2.0, 2.5, 1.0).hold(0.5).swing(10)
    with pytest.raises(TrialError, match=r"double pendulum|contradict"):
        check(made, lambda joints: np.column_stack([joints[:, 0], np.zeros(len(joints))]))


@pytest.mark.parametrize("noise", [1e-3, 5e-3, 10e-3])
@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_noise_neither_passes_wrong_conventions_nor_refuses_right_ones(recording, noise, rate):
    made = recording(rate=rate).carry(2.0, 2.5, 1.0).hold(0.5).swing(10)
    noisy = made.joints(noise=noise)
    assert check(made, lambda _: noisy)[0].lumped.is_mechanism
    with pytest.raises(TrialError):
        check(made, lambda _: noisy, outer_angle="absolute")
    with pytest.raises(TrialError):
        check(made, lambda _: noisy, outer_sign=-1)


def test_what_a_small_swing_cannot_tell_is_said_and_not_held_against_it(recording):
    made = recording().carry(np.pi + 0.02, np.pi + 0.04, 1.0).hold(0.5).swing(10)
    noisy = made.joints(noise=1e-3)
    _, warnings = check(made, lambda _: noisy, rest_amplitude=1e-3)
    assert any("too small, too short or too noisy" in warning or "cannot tell" in warning for warning in warnings)


def test_zeros_that_are_a_little_off_contradict_nothing(swing):
    balance, warnings = check(swing, lambda joints: joints + np.array([0.03, -0.05]))
    assert warnings == []
    values = balance.lumped.values
    assert values[10:12] / values[4:6] == pytest.approx([-0.03, 0.02], abs=3e-3)


def test_a_joint_in_degrees_is_told_beside_one_that_turns_over(recording):
    whirl = recording().carry(2.0, 2.5, 1.0).swing(8, (0.0, 25.0))
    samples = Samples(whirl.stamps(), whirl.joints() * [180.0 / np.pi, 1.0], None)
    with pytest.raises(TrialError, match="the inner joint is in degrees: inner_unit: degrees leaves"):
        find_trial(samples, TrialOptions())


@pytest.mark.parametrize("unit", ["gradians", "milliradians"])
def test_rarer_units_are_told_too(swing, unit):
    factors = np.array([1.0, 1.0 / UNITS[unit]])
    for of in (factors, factors[1]):
        samples = Samples(swing.stamps(), swing.joints() * of, None)
        with pytest.raises(TrialError, match=rf"in {unit}: .*outer_unit: {unit} leaves 0\.0%"):
            find_trial(samples, TrialOptions())


def test_a_cart_in_other_units_is_told_from_other_causes(swing):
    counts = 20_000.0 + np.round(3.0 * np.sin(2e-9 * (swing.stamps() - swing.stamps()[0])))
    with pytest.raises(TrialError, match=r"the cart's readings are no metres: cart_joint: '' leaves 0\.0%"):
        find_trial(Samples(swing.stamps(), swing.joints(), counts), TrialOptions())
