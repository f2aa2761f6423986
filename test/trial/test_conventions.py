# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.bag.reader import read_joint_states
from cdp_ident.errors import TrialError
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.trial.conventions import check_conventions, gravity_of, in_right_ranges
from cdp_ident.trial.find import find_trial
from cdp_ident.trial.joints import Samples, model_angles
from cdp_ident.trial.options import UNITS, TrialOptions
from cdp_ident.trial.recorded_motion import recorded_motion
from reference.pendulum import TABLE_5, motion

BAGS = Path(__file__).parents[2] / "bags"


@pytest.fixture(scope="module")
def swing(recording):
    """A recording no longer than it has to be: many meanings of its angles are tried."""
    return recording(rate=100.0).carry(2.0, 2.5, 1.0).hold(0.5).swing(6)


def check(made, change=lambda joints: joints, **options):
    options = TrialOptions(**options)
    joints = change(made.joints())
    return check_conventions(recorded_motion(Samples(made.stamps(), joints, None), options), options)


def test_right_conventions_pass_without_a_word(swing):
    balance, warnings = check(swing)
    assert warnings == []
    assert balance.lumped.is_mechanism
    assert balance.lumped.unexplained < 0.01


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (
            lambda inner, outer: (inner - np.pi, inner + outer - np.pi),
            {},
            r"outer_angle: absolute and zero: hanging leaves 0\.\d%",
        ),
        (
            lambda inner, outer: (inner, inner + outer - np.pi),
            {},
            r"outer_angle: absolute and the outer joint's zero half a turn on leaves 0\.\d%",
        ),
        (
            lambda inner, outer: (inner, outer),
            {"zero": "hanging"},
            r"gravity terms of the rods -\d+\.\d and -\d+\.\d 1/s\^2",
        ),
        (lambda inner, outer: (inner + np.pi, outer - np.pi), {}, "the zero of the inner joint is half a turn"),
        (lambda inner, outer: (inner, 0.0 * outer), {}, r"double pendulum|contradict"),
    ],
    ids=["absolute hanging", "absolute with another zero", "evidence", "inner zero", "locked outer rod"],
)
def test_the_refusal_names_everything_that_would_have_to_be_set(swing, change, options, message):
    with pytest.raises(TrialError, match=message):
        check(swing, lambda joints: np.column_stack(change(*joints.T)), **options)


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
    for of in (factors, factors[::-1], factors[1]):
        samples = Samples(swing.stamps(), swing.joints() * of, None)
        with pytest.raises(TrialError, match=rf"in {unit}: .*(inner|outer)_unit: {unit} leaves 0\.0%"):
            find_trial(samples, TrialOptions())


def test_a_cart_in_other_units_is_told_from_other_causes(swing):
    counts = 20_000.0 + np.round(3.0 * np.sin(2e-9 * (swing.stamps() - swing.stamps()[0])))
    with pytest.raises(TrialError, match=r"the cart's readings are no metres: cart_joint: '' leaves 0\.0%"):
        find_trial(Samples(swing.stamps(), swing.joints(), counts), TrialOptions())


@pytest.fixture(scope="module")
def samples(swing):
    return Samples(swing.stamps(), swing.joints(), None)


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


@pytest.mark.parametrize("turns", [2**16 / 12_000, 2**10 / 2000, 2**16 / 10_000])
def test_no_other_range_of_a_counter_hides_a_zero_that_is_half_a_turn_off(samples, turns):
    ranges = (2 * np.pi * turns, 0.0)
    hanging = replace(samples, angles=samples.angles - [np.pi + ranges[0], 0.0], ranges=ranges)
    with pytest.raises(TrialError, match=r"the data contradict zero: upright .*: set zero: hanging"):
        find_trial(in_right_ranges(hanging, TrialOptions()), TrialOptions())


def test_rods_that_hardly_move_leave_a_counter_as_it_is(samples):
    still = replace(samples, angles=np.zeros_like(samples.angles), ranges=(0.2, 0.2))
    assert in_right_ranges(still, TrialOptions()) is still


def read_as(samples, inner, outer):
    """What encoders show whose counts per turn are wrong, and that are right where the rods hang."""
    hanging = np.array([np.pi, 0.0])
    return Samples(samples.stamps, hanging + (samples.angles - hanging) * np.array([inner, outer]), None)


@pytest.mark.parametrize(
    ("factors", "options", "message"),
    [
        ((4.0, 1.0), {}, "the inner joint's readings are 4 times the angle: inner_scale: 4 leaves"),
        ((1.0, 0.5), {}, r"the outer joint's readings are 0\.5 times the angle: outer_scale: 0\.5 leaves"),
        (
            (0.25, 0.25),
            {},
            r"readings of both joints are 0\.25 times the angle: inner_scale: 0\.25 and outer_scale: 0\.25 leaves",
        ),
        ((1.0, 0.3), {}, r"outer_scale: 0\.(3|299\d*|300\d*) leaves"),
        ((1.37, 1.37), {}, r"inner_scale: 1\.3(7|6\d|7\d) and outer_scale: 1\.3(7|6\d|7\d) leaves"),
        ((1.0, 0.5), {"outer_scale": 2.0}, r"outer_scale: 0\.(5|49\d+|50\d+) leaves"),
    ],
)
def test_counts_that_are_wrong_are_refused_with_the_factor_on_what_is_set(samples, factors, options, message):
    with pytest.raises(TrialError, match=f"{message}.*check the counts per turn, or set that"):
        find_trial(read_as(samples, *factors), TrialOptions(**options))


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0, 4.0])
@pytest.mark.parametrize("bag", ["swing_check", "swing_folded", "swing_wide"])
def test_edges_that_are_counted_or_not_are_told_of_an_encoder_whatever_the_motion(bag, factor):
    recording = read_joint_states(BAGS / bag, "joint_states")
    angles = recording.positions[:, [recording.joints.index(joint) for joint in ("inner_joint", "outer_joint")]]
    wrong = read_as(Samples(recording.stamps, angles, None), factor, factor)
    with pytest.raises(TrialError, match=rf"inner_scale: {factor:g} and outer_scale: {factor:g} .*leaves 0\.0%"):
        find_trial(wrong, TrialOptions())


def test_readings_that_are_right_at_zero_are_told_from_those_that_are_right_where_the_rods_hang(samples):
    wrong = Samples(samples.stamps, samples.angles * np.array([4.0, 1.0]), None)
    with pytest.raises(TrialError, match="inner_scale: 4 and scale_from: zero leaves"):
        find_trial(wrong, TrialOptions())
    mended = find_trial(wrong, TrialOptions(inner_scale=4.0, scale_from="zero"))
    assert mended.trial.theta == pytest.approx(find_trial(samples, TrialOptions()).trial.theta, abs=1e-9)


@pytest.mark.parametrize("counts", [1e-4, 2 * np.pi / 1024])
def test_gaps_are_no_fault_of_the_angles_and_no_torque_acts_in_them(samples, counts):
    coarse = replace(samples, angles=np.round(samples.angles / counts) * counts)
    found = find_trial(coarse[np.arange(len(samples.angles)) % 150 >= 10], TrialOptions())
    assert found.warnings == ()
    assert not any("for an instant" in note for note in found.trial.notes)
    assert found.trial.duration == pytest.approx(find_trial(samples, TrialOptions()).trial.duration, abs=0.3)


@pytest.mark.parametrize("joints", [(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])
def test_turns_are_told(samples, joints):
    wrong = Samples(samples.stamps, samples.angles / (2 * np.pi) ** np.array(joints), None)
    with pytest.raises(TrialError, match=r"0\.1592 times the angle \(turns\?\)"):
        find_trial(wrong, TrialOptions())


@pytest.mark.parametrize("per_radian", [4096 / (2 * np.pi), 18000 / np.pi])
def test_readings_that_turn_too_far_are_in_another_unit(swing, samples, per_radian):
    set_right = TrialOptions(inner_scale=per_radian, outer_scale=per_radian, scale_from="zero")
    counted = find_trial(Samples(samples.stamps, np.round(samples.angles * per_radian), None), set_right).trial
    angles = model_angles(samples.angles, TrialOptions())[round(counted.start * swing.rate) :]
    assert counted.theta == pytest.approx(angles[: len(counted.time)], abs=0.01)
    for factors in ((per_radian, 1.0), (1.0, per_radian), (per_radian, per_radian)):
        counts = np.round(samples.angles * np.array(factors))
        with pytest.raises(TrialError, match="quarter of a turn from sample to sample: its readings are no radians"):
            find_trial(Samples(samples.stamps, counts, None), TrialOptions())


def test_the_factor_that_the_refusal_names_puts_the_angles_right(samples):
    right = find_trial(samples, TrialOptions())
    mended = find_trial(read_as(samples, 1.0, 0.5), TrialOptions(outer_scale=0.5))
    assert mended.warnings == right.warnings == ()
    assert mended.trial.theta == pytest.approx(right.trial.theta, abs=1e-9)


@pytest.mark.parametrize("factors", [(1.0, 2.0), (1.0, 1.37), (0.7, 0.7)])
def test_a_factor_with_which_forces_balance_in_small_swings_is_named_and_not_taken_for_a_hand(factors):
    time = np.arange(0.0, 10.0, 0.005)
    theta = motion(TABLE_5, (2.2, 2.9, 0.0, 0.0), time)[:, :2]
    angles = np.column_stack([theta[:, 0], theta[:, 1] - theta[:, 0]])
    angles += 1e-4 * np.random.default_rng(1).normal(size=angles.shape)
    swing = Samples(np.round(time * 1e9).astype(np.int64), angles, None)
    with pytest.raises(TrialError, match="times the angle") as refused:
        find_trial(read_as(swing, *factors), TrialOptions())
    named = {name: float(value) for name, value in re.findall(r"(inner_scale|outer_scale): (\S+)", str(refused.value))}
    assert [named.get("inner_scale", 1.0), named.get("outer_scale", 1.0)] == pytest.approx(factors, rel=0.01)


@pytest.mark.parametrize("outer_angle", ["absolute", "relative"])
@pytest.mark.parametrize("start", [0.15, 0.4])
def test_noise_in_a_small_swing_is_no_evidence_against_what_its_angles_mean(start, outer_angle):
    time = np.arange(0.0, 8.0, 0.01)
    angles = motion(TABLE_5, (np.pi + 0.2 * start, np.pi + start, 0.0, 0.0), time)[:, :2]
    angles += 4e-3 * np.random.default_rng(0).normal(size=angles.shape)
    if outer_angle == "relative":
        angles[:, 1] -= angles[:, 0]
    swing = Samples(np.round(time * 1e9).astype(np.int64), angles, None)
    find_trial(swing, TrialOptions(outer_angle=outer_angle))


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        ([1.0, 180 / np.pi], {"outer_unit": "degrees"}),
        ([1.0, 4.0], {"outer_scale": "4"}),
    ],
)
def test_two_rods_that_hold_up_to_noise_win_over_one_pendulum_on_an_arm(recording, readings, said):
    made = recording({**NOMINAL, "c1": 0.01, "c2": 0.003}, rate=100.0).carry(4.0, 4.4, 1.0).hold(0.5).swing(10)
    with pytest.raises(TrialError, match=r"leaves 0\.\d%") as refused:
        find_trial(Samples(made.stamps(), made.joints() * readings, None), TrialOptions())
    options = dict(re.findall(r"(outer_\w+): (\S+)", str(refused.value)))
    assert options == said
    assert "pendulum on an arm" not in str(refused.value)


@pytest.mark.parametrize(
    ("start", "zero", "sign"), [(3.6, 0.0, 1), (3.6, 0.0, -1), (3.6, np.pi, 1), (3.5, 0.0, 1), (3.4, np.pi, -1)]
)
def test_absolute_angles_of_a_small_swing_are_told_though_little_is_left_under_others(recording, start, zero, sign):
    made = recording().carry(start, start + 0.4, 1.0).hold(0.5).swing(12)
    joints = made.joints() @ [[1.0, 1.0], [0.0, 1.0]] - zero
    with pytest.raises(TrialError, match=r"outer_angle: absolute.* leaves 0\.0%.*; set that") as refused:
        find_trial(Samples(made.stamps(), joints * [1, sign], None), TrialOptions())
    told = str(refused.value).partition("outer_sign: 1: ")[2]
    assert ("zero: hanging" in told, "outer_sign: -1" in told) == (zero > 0.0, sign < 0)


@pytest.mark.parametrize("factors", [(4.0, 1.0), (1.0, 0.25), (2.0, 2.0)])
def test_readings_with_a_factor_and_the_other_zero_are_named_with_what_puts_both_right(samples, factors):
    wrong = Samples(samples.stamps, (samples.angles - [np.pi, 0.0]) * factors, None)
    with pytest.raises(TrialError, match=r"zero: hanging and .* leaves 0\.0%") as refused:
        find_trial(wrong, TrialOptions())
    scales = {name: float(value) for name, value in re.findall(r"(inner_scale|outer_scale): (\S+)", str(refused.value))}
    assert (scales.get("inner_scale", 1.0), scales.get("outer_scale", 1.0)) == factors
    mended = find_trial(wrong, TrialOptions(zero="hanging", scale_from="zero", **scales))
    assert mended.trial.theta == pytest.approx(find_trial(samples, TrialOptions()).trial.theta, abs=1e-9)


def test_a_meaning_that_explains_nothing_is_not_advised(recording):
    made = recording(rate=100.0).carry(2.6, 4.2, 1.0).hold(0.5).swing(10)
    wrong = (made.joints() - [np.pi, 0.0]) * [-0.25, 1.0]
    with pytest.raises(TrialError) as refused:
        find_trial(Samples(made.stamps(), wrong, None), TrialOptions())
    assert "set that" not in str(refused.value)
