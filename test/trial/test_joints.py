# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.errors import TrialError
from cdp_ident.trial.joints import select_joints
from cdp_ident.trial.options import TrialOptions

STAMPS = 10**18 + np.arange(6) * 10**7
NAN = np.nan


def recording(positions, joints=("cart_joint", "inner_joint", "outer_joint")):
    return JointRecording("swing", "/joint_states", joints, STAMPS, np.array(positions, dtype=float), ())


def test_joints_are_found_by_name_whatever_their_order():
    samples, notes = select_joints(recording([[1, 2, 3]] * 6, ("outer_joint", "other", "inner_joint")), TrialOptions())
    assert samples.angles.tolist() == [[3, 1]] * 6
    assert samples.cart is None
    assert notes == ["there is no joint cart_joint: the cart is taken to be at rest"]


def test_a_cart_published_apart_is_taken_at_the_times_of_the_rods():
    positions = [[0, NAN, NAN], [NAN, 1, 2], [0.2, NAN, NAN], [NAN, 1, 2], [0.4, NAN, NAN], [NAN, 1, 2]]
    samples, notes = select_joints(recording(positions), TrialOptions())
    assert np.allclose(samples.cart, [0.1, 0.3, 0.4])
    assert samples.stamps.tolist() == STAMPS[1::2].tolist()
    assert "3 of 6 samples" in notes[0]


@pytest.mark.parametrize("bad", [NAN, np.inf, -np.inf, 1e300])
def test_numbers_that_are_no_measurements_are_dropped(bad):
    samples, notes = select_joints(recording([[0, 1, 2]] * 5 + [[0, bad, 2]]), TrialOptions())
    assert len(samples.stamps) == 5
    assert "1 of 6 samples" in notes[0]


def test_no_usable_number_at_all_is_an_error():
    with pytest.raises(TrialError, match="no sample of /joint_states has a usable number"):
        select_joints(recording([[0, NAN, 2]] * 6), TrialOptions())


@pytest.mark.parametrize(("far", "known"), [(5.0, 400), (7.0, 390)])
def test_a_number_stored_often_and_far_from_all_others_is_no_reading(far, known):
    number = np.arange(400)
    swing = 2.0 * np.sin(number / 9.0)
    positions = np.column_stack([np.where(number % 40 == 20, far, swing), swing])
    joints = ("inner_joint", "outer_joint")
    of_swing = JointRecording("swing", "/joint_states", joints, 10**18 + number * 5_000_000, positions, ())
    samples, notes = select_joints(of_swing, TrialOptions(cart_joint=""))
    assert len(samples.stamps) == known
    assert ("10 readings of inner_joint that are 7 stand for missing ones, and are left out" in notes) is (known < 400)


def test_a_cart_is_bridged_where_its_position_is_an_outlier_and_the_rods_samples_stay():
    stamps = 10**18 + np.arange(400) * 5_000_000
    truth = 0.1 * np.sin(np.arange(400) * 0.02)
    cart = truth.copy()
    cart[[100, 250]] += [3.0, -0.05]
    positions = np.column_stack([cart, np.ones(400), np.ones(400)])
    samples, notes = select_joints(
        JointRecording("swing", "/joint_states", ("cart_joint", "inner_joint", "outer_joint"), stamps, positions, ()),
        TrialOptions(),
    )
    assert len(samples.stamps) == 400
    assert samples.cart == pytest.approx(truth, abs=1e-4)
    assert notes == ["of the cart's position 2 outliers (0.5 %) are left out, the first at 0.500 s"]


def test_torques_in_messages_of_their_own_are_taken_at_the_times_of_the_rods():
    positions = [[1, 2], [NAN, NAN]] * 3
    efforts = np.array([[NAN, NAN], [0.1, NAN], [NAN, NAN], [0.3, NAN], [NAN, NAN], [0.5, NAN]])
    samples, _ = select_joints(
        replace(recording(positions, ("inner_joint", "outer_joint")), efforts=efforts), TrialOptions()
    )
    assert samples.torques == pytest.approx(np.array([[0.1, 0.0], [0.2, 0.0], [0.4, 0.0]]))
