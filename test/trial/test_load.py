# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a bag to the zero-input motion in it."""

from pathlib import Path

import numpy as np
import pytest

from cdp_ident.errors import TrialError
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.outliers import TURN, outliers

pytestmark = pytest.mark.long

MEASURED = Path(__file__).parents[3] / "shared/data/multiarm_free_swing/free_swing_8s_56s_1kHz.csv.gz"
START = 1_700_000_000_000_000_000


def bag_of(make_bag, recording, **joints):
    return make_bag(recording.stamps(), recording.joints(**joints))


def test_a_release_from_rest_gives_the_free_motion_in_the_model_s_angles(recording, make_bag):
    made = recording().carry(2.0, 2.5, 1.5).hold(1.0)
    release = made.now
    made.swing(20)
    bag = bag_of(make_bag, made)
    trial = load_trial(bag)
    assert trial.name == bag.name
    assert release - 0.01 <= trial.start <= release + 0.3
    assert trial.start + trial.duration == pytest.approx(made.now - 1 / made.rate, abs=1e-6)
    first = round(trial.start * made.rate)
    truth = np.concatenate(made.theta)[first:]
    assert np.abs(trial.theta - truth).max() < 2e-3
    assert np.allclose(np.diff(trial.time), 1 / made.rate)
    assert trial.cart is None
    assert any("a hand is at the rods" in note for note in trial.notes)


def test_a_hand_that_lets_go_of_moving_rods_is_cut(recording, make_bag):
    made = recording().carry(2.2, 2.0, 1.0)
    release = made.now
    trial = load_trial(bag_of(make_bag, made.swing(12, (-2.0, -1.0))))
    assert release - 0.01 <= trial.start <= release + 0.3


def test_a_bag_that_begins_and_ends_swinging_is_taken_whole(recording, make_bag):
    made = recording().carry(1.0, 1.2, 1.0).swing(15)
    late = made.now - 14
    trial = load_trial(bag_of(make_bag, made), TrialOptions(start=late))
    assert trial.start == pytest.approx(late, abs=0.01)
    assert trial.duration == pytest.approx(14, abs=0.02)


def test_of_two_swings_the_longer_is_taken_and_the_other_named(recording, make_bag):
    made = recording().carry(2.0, 2.2, 1.0).hold(0.5).swing(8).carry(2.5, 3.0, 0.7).hold(1).carry(1.5, 1.0, 1).hold(1)
    release = made.now
    trial = load_trial(bag_of(make_bag, made.swing(15)))
    assert release - 0.01 <= trial.start <= release + 0.3
    assert any("another zero-input part from" in note for note in trial.notes)


@pytest.mark.parametrize("hertz", [2, 4, 5])
def test_samples_that_are_too_far_apart_are_told_as_such(swing, make_bag, hertz):
    slow = np.s_[:: 200 // hertz]
    with pytest.raises(TrialError, match=rf"apart \({hertz} Hz\), which is too slow .* need 20 Hz, shorter ones more"):
        load_trial(make_bag(swing.stamps()[slow], swing.joints()[slow]))


def test_the_rest_at_the_end_is_cut(recording, make_bag):
    made = recording({**recording().values, "c1": 0.02, "c2": 0.01}).carry(2.0, 2.2, 1.0).hold(0.5).swing(60)
    trial = load_trial(bag_of(make_bag, made))
    assert 5 < trial.duration < 50
    assert any("the rods are still" in note for note in trial.notes)
    end = trial.theta[trial.time > trial.duration - 1]
    assert 0.001 < np.abs(end - np.pi).max() < 0.05


@pytest.mark.parametrize("seed", [*range(3), *(pytest.param(n, marks=pytest.mark.campaign) for n in range(3, 40))])
def test_wherever_and_whenever_the_hand_lets_go_nothing_of_it_stays_and_little_is_lost(recording, make_bag, seed):
    generator = np.random.default_rng(seed)
    posture = np.pi + generator.choice([-1, 1], 2) * generator.uniform(0.4, 2.5, 2)
    made = recording(rate=generator.choice([100.0, 200.0, 500.0])).hold(generator.uniform(0, 3))
    made.carry(*posture, generator.uniform(0.7, 2.0)).hold(generator.uniform(0.0, 10.0))
    release = made.now
    made.swing(generator.uniform(5, 15))
    trial = load_trial(bag_of(make_bag, made, noise=generator.choice([0, 5e-4, 2e-3]), seed=seed))
    assert release - 1.5 / made.rate <= trial.start <= release + 0.3
    assert trial.start + trial.duration == pytest.approx(made.now, abs=1.5 / made.rate)


@pytest.mark.parametrize("lead", [1.0, 3.0])
def test_a_swing_too_short_to_be_told_from_the_hand_s_lead_in_is_refused(recording, make_bag, lead):
    made = recording().hold(0.5).carry(2.0, 2.5, lead).hold(0.3)
    release = made.now
    bag = bag_of(make_bag, made.swing(0.8).hold(0.5))
    with pytest.raises(TrialError, match=r"tell a hand from free motion: .* by start and stop"):
        load_trial(bag)
    taken = load_trial(bag, TrialOptions(start=release, stop=release + 0.8))
    assert taken.duration == pytest.approx(0.8, abs=0.05)


@pytest.mark.parametrize("factor", [15, 22, 30])
def test_rods_whose_joints_damp_them_before_the_hand_is_forgotten_are_free_from_the_release(
    recording, make_bag, factor
):
    made = recording({**NOMINAL, "c1": factor * NOMINAL["c1"], "c2": factor * NOMINAL["c2"]})
    made.carry(2.0, 2.5, 1.0).hold(0.5)
    release = made.now
    trial = load_trial(bag_of(make_bag, made.swing(10)))
    assert release <= trial.start < release + 0.35
    assert not any("angles mean" in note for note in trial.notes)


def test_a_hand_that_catches_moving_rods_ends_the_trial(recording, make_bag):
    made = recording().carry(2.6, 2.9, 1.2).hold(2.0).swing(10)
    catch = made.now
    trial = load_trial(bag_of(make_bag, made.carry(3.0, 3.2, 0.4).hold(2)))
    assert catch - 0.4 <= trial.start + trial.duration <= catch + 0.02


def test_an_impulse_stays_in_the_trial_and_is_noted(recording, make_bag):
    made = recording().carry(2.0, 2.5, 1.0).hold(0.5).swing(6)
    impulse = made.now
    trial = load_trial(bag_of(make_bag, made.swing(8, (1.5, 0.0))))
    assert trial.start < impulse - 4
    assert trial.duration > 12
    note = next(note for note in trial.notes if "an impulse" in note)
    assert float(note.split()[1]) == pytest.approx(impulse, abs=0.1)


def test_wrapped_angles_are_unwrapped(recording, make_bag):
    made = recording().carry(0.4, 0.2, 1.0).hold(0.5).swing(10)
    joints = made.joints()
    whole = load_trial(make_bag(made.stamps(), joints))
    wrapped = load_trial(make_bag(made.stamps(), np.mod(joints, 2 * np.pi)))
    turns = (wrapped.theta - whole.theta) / (2 * np.pi)
    assert np.ptp(whole.theta[:, 1]) > 2 * np.pi  # the outer rod does go over the top
    assert np.allclose(turns, np.round(turns[0]), atol=1e-9)


@pytest.mark.parametrize(
    ("options", "change"),
    [
        ({"outer_angle": "absolute"}, lambda inner, outer: (inner, inner + outer)),
        ({"zero": "hanging"}, lambda inner, outer: (inner - np.pi, outer)),
        ({"zero": "hanging", "outer_angle": "absolute"}, lambda inner, outer: (inner - np.pi, inner + outer - np.pi)),
        ({"inner_sign": -1, "outer_sign": -1}, lambda inner, outer: (-inner, -outer)),
        ({"outer_sign": -1}, lambda inner, outer: (inner, -outer)),
        ({"inner_sign": -1, "zero": "hanging"}, lambda inner, outer: (np.pi - inner, outer)),
    ],
)
def test_other_conventions_give_the_same_trial_and_are_refused_where_the_options_deny_them(
    swing, make_bag, options, change
):
    bag = make_bag(swing.stamps(), np.column_stack(change(*swing.joints().T)))
    truth = load_trial(make_bag(swing.stamps(), swing.joints()))
    trial = load_trial(bag, TrialOptions(**options))
    assert np.allclose(trial.theta, truth.theta)
    mirror = {"inner_sign": -1, "outer_sign": -1}
    if options != mirror:  # a pendulum in a mirror is a pendulum
        with pytest.raises(TrialError, match="contradict"):
            load_trial(bag)


def test_an_outer_zero_half_a_turn_off_is_refused(swing, make_bag):
    with pytest.raises(TrialError, match="the zero of the outer joint is half a turn"):
        load_trial(make_bag(swing.stamps(), swing.joints() + np.array([0, np.pi])))


def test_contradicted_conventions_may_be_insisted_on(swing, make_bag):
    trial = load_trial(make_bag(swing.stamps(), swing.joints()), TrialOptions(zero="hanging", conventions="warn"))
    assert any("contradict zero: hanging" in note for note in trial.notes)


def test_a_small_cart_motion_stays_and_is_part_of_the_trial(swing, make_bag):
    joints = swing.joints()
    cart = 0.002 * np.sin(np.arange(len(joints)) * 0.01)
    names = ("slider", "a", "b")
    bag = make_bag(swing.stamps(), np.column_stack([cart, joints]), names)
    options = TrialOptions(inner_joint="a", outer_joint="b", cart_joint="slider", cart_sign=-1)
    trial = load_trial(bag, options)
    first = round(trial.start * swing.rate)
    assert np.allclose(trial.cart, -cart[first : first + len(trial.cart)])


def test_where_the_cart_is_driven_the_trial_ends(swing, make_bag):
    joints = swing.joints()
    time = np.arange(len(joints)) / swing.rate
    cart = np.where(time > 9.0, 0.1 * (1 - np.cos(3 * (time - 9.0))), 0.0)
    bag = make_bag(swing.stamps(), np.column_stack([joints, cart]), ("inner_joint", "outer_joint", "cart_joint"))
    trial = load_trial(bag)
    assert 8.5 < trial.start + trial.duration <= 9.3
    assert any("the cart is driven" in note for note in trial.notes)


def test_duplicates_late_samples_and_nan_are_counted(swing, make_bag):
    stamps, joints = swing.stamps(), swing.joints()
    joints[700:703] = np.nan
    stamps[900] = stamps[899]
    stamps[1200] = stamps[1190]
    trial = load_trial(make_bag(stamps, joints))
    notes = "; ".join(trial.notes)
    assert "3 of " in notes
    assert "2 samples with a stamp that was there already" in notes
    assert "1 samples that were stored late are put where their stamps belong" in notes
    assert np.all(np.diff(trial.time) > 0)
    assert not np.any(np.isnan(trial.theta))


def with_gap(swing, make_bag, samples):
    stamps, joints = swing.stamps(), swing.joints()
    keep = np.ones(len(stamps), dtype=bool)
    keep[1000 : 1000 + samples] = False
    return load_trial(make_bag(stamps[keep], joints[keep]))


def test_a_gap_longer_than_a_swing_parts_the_recording_and_the_longer_part_is_taken(swing, make_bag):
    trial = with_gap(swing, make_bag, 400)
    assert trial.start == pytest.approx(1400 / swing.rate)
    assert any("a gap of 2.005 s" in note for note in trial.notes)
    assert trial.breaks == ()


def test_what_is_on_both_sides_of_a_shorter_gap_is_one_trial_of_two_stretches(swing, make_bag):
    trial = with_gap(swing, make_bag, 60)
    assert trial.start < 1000 / swing.rate
    (at,) = trial.breaks
    assert trial.start + trial.time[at] == pytest.approx(1060 / swing.rate)
    assert any("a gap of 0.305 s" in note for note in trial.notes)
    whole = load_trial(make_bag(swing.stamps(), swing.joints()))
    assert trial.theta[-1] == pytest.approx(whole.theta[-1])


def test_stamps_are_taken_as_they_are(swing, make_bag):
    jitter = np.random.default_rng(5).integers(-100_000, 100_000, len(swing.stamps()))
    stamps = swing.stamps() + jitter
    trial = load_trial(make_bag(stamps, swing.joints()))
    first = np.flatnonzero(np.isclose((stamps - stamps[0]) * 1e-9, trial.start, atol=1e-9))[0]
    assert np.allclose(trial.time, (stamps[first:] - stamps[first]) * 1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("made", "options", "message"),
    [
        (lambda made: made.hold(10), {}, "the rods are still"),
        (lambda made: made.carry(2.0, 2.5, 0.2).swing(1.0), {"shortest": 2.0}, r"hold no stretch of 2 s"),
        (
            lambda made: made.carry(2.0, 2.5, 1.0).hold(2).swing(1.5).carry(2.5, 2.5, 0.5).hold(5),
            {"shortest": 2.0},
            r"no zero-input motion of at least 2 s.*a hand",
        ),
    ],
)
def test_rest_a_short_bag_and_a_motion_that_is_soon_caught_are_no_trial(recording, make_bag, made, options, message):
    with pytest.raises(TrialError, match=message):
        load_trial(bag_of(make_bag, made(recording())), TrialOptions(**options))


def test_missing_joints_are_named_with_those_that_are_there(swing, make_bag):
    bag = make_bag(swing.stamps(), swing.joints(), ("arm", "forearm"))
    with pytest.raises(TrialError, match="no joint inner_joint and no joint outer_joint; it has arm, forearm"):
        load_trial(bag)


def test_a_time_range_outside_the_bag_is_refused(swing, make_bag):
    with pytest.raises(TrialError, match=r"no sample lies within start: 1000\.0 s: the recording has"):
        load_trial(bag_of(make_bag, swing), TrialOptions(start=1000.0))


def test_a_joint_that_sticks_for_good_is_no_hand(make_bag):
    coefficients = physical_coefficients({**NOMINAL, "c1": 0.002, "c2": 0.0005})
    dry = next(effect for effect in CATALOGUE if (effect.name, effect.joint) == ("coulomb_friction", "outer"))
    A23, *_, L, g = coefficients
    friction = ActingEffects.of([(dry, [0.3 * A23 / L * g])], 0.4)
    time = np.arange(1600) * 0.005
    theta = simulate(coefficients, np.array([2.2, 2.9, 0, 0]), time, effects=friction)[:, :2]
    relative = theta[:, 1] - theta[:, 0]
    assert np.ptp(relative[-800:]) < 0.1 < np.ptp(theta[-800:, 0])
    noise = np.random.default_rng(2).normal(0, 3e-4, (len(time), 2))
    trial = load_trial(
        make_bag(START + np.round(time * 1e9).astype(np.int64), np.column_stack([theta[:, 0], relative]) + noise)
    )
    assert trial.duration == pytest.approx(time[-1], abs=0.02)


def test_spikes_are_left_out_told_with_their_places_and_change_nothing_else(swing, make_bag):
    made = swing
    joints = np.mod(made.joints(noise=5e-4), 2 * np.pi)
    clean = load_trial(make_bag(made.stamps(), joints))
    spikes = [40, 700, 1100, 1101, 1900]
    joints[spikes, [0, 1, 0, 0, 1]] += [1.0, 3.1, -0.6, -0.6, 0.02]
    trial = load_trial(make_bag(made.stamps(), joints))
    assert trial.outliers == pytest.approx(np.array(spikes[1:]) / made.rate, abs=1e-6)
    assert "4 outliers (0.2 %) are left out, the first at 3.500 s" in trial.notes
    assert not any("gaps" in note for note in trial.notes)
    assert trial.start == pytest.approx(clean.start, abs=1.5 / made.rate)
    there, here = (np.round((one.start + one.time) * made.rate).astype(int).tolist() for one in (clean, trial))
    assert set(there[5:]) - set(here) == set(spikes[1:])
    common = sorted(set(there) & set(here))
    assert np.array_equal(trial.theta[np.searchsorted(here, common)], clean.theta[np.searchsorted(there, common)])


@pytest.mark.skipif(not MEASURED.exists(), reason="the measured free swing is not beside the repository")
@pytest.mark.parametrize("every", [1, 5, 20])
def test_a_measured_swing_has_no_outliers(every):
    time, theta1, theta2 = np.loadtxt(MEASURED, delimiter=",", skiprows=1, usecols=(0, 1, 2))[::every].T
    assert not np.any(outliers(time, theta1, TURN))
    assert not np.any(outliers(time, theta2, TURN))
