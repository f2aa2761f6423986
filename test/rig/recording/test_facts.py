# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is said about a trial."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.bag.joint_state import serialize_joint_state
from cdp_ident.rig.recording.detector import End
from cdp_ident.rig.recording.facts import JointNames, Position, PositionReader, TrialFacts


def facts(count=2000, cart_step=0.0, missing=frozenset()):
    result = TrialFacts(0.002, 5.0, 1_000_000_000, started_by_hand=False)
    for number in range(count):
        if number not in missing:
            stamp = number * 5_000_000
            cart = 0.5 if stamp < 1_000_000_000 else cart_step * number
            result.take(Position(stamp, 3.0, 0.0, cart))
    return result


def test_a_good_trial_has_no_warnings():
    good = facts()
    assert good.warnings() == []
    metadata = good.as_metadata(End.AT_REST, {"rest": 0.01})
    assert metadata["cart_at_rest"] == "true"
    assert (metadata["samples"], metadata["samples_lost"], metadata["duration_s"]) == ("2000", "0", "8.995")
    assert json.loads(metadata["parameters"]) == {"rest": 0.01}
    assert all(isinstance(value, str) for value in metadata.values())


def test_stamps_that_went_back_are_said():
    set_back = facts()
    set_back.take(Position(9_800_000_000, 3.0, 0.0, None))
    assert set_back.warnings() == ["the stamps went back 1 times"]


def test_a_cart_that_is_not_measured_is_not_said_to_be_at_rest():
    result = TrialFacts(0.002, 0.0, 0, started_by_hand=True)
    result.take(Position(0, 3.0, 0.0, None))
    assert result.as_metadata(End.STOPPED, {})["cart_at_rest"] == "not measured"


def test_positions_are_read_by_the_joints_names():
    reader = PositionReader(JointNames("c", "a", "b"))
    assert reader.read(serialize_joint_state(["b", "x", "a"], [2.0, 9.0, 1.0], 7)) == Position(7, 1.0, 2.0, None)
    plain, driven = ([["a", "b", "c"], [1.0, 2.0, 3.0], 8, (), efforts] for efforts in ((), [0.1, 0.2, 0.3]))
    assert reader.read(serialize_joint_state(*plain)) == Position(8, 1.0, 2.0, 3.0)
    with_torques = PositionReader(JointNames("c", "a", "b"), with_torques=True)
    assert with_torques.read(serialize_joint_state(*driven)) == Position(8, 1.0, 2.0, 3.0, (0.1, 0.2))
    assert with_torques.read(serialize_joint_state(*plain)) == Position(8, 1.0, 2.0, 3.0)
    assert reader.read(serialize_joint_state(["a"], [1.0], 9)) is None
    assert reader.read(serialize_joint_state(["a", "b"], [1.0, float("nan")], 9)) is None


@given(raw=st.binary(max_size=200))
def test_arbitrary_bytes_are_no_position(raw):
    assert PositionReader(JointNames()).read(raw) is None


def test_how_even_the_stamps_are_is_told_lost_samples_or_not():
    even = facts(missing=frozenset(range(500, 510)))
    assert even.unevenness() == pytest.approx((0.0, 0.0), abs=1e-8)
    uneven = TrialFacts(0.002, 5.0, 0, started_by_hand=False)
    for number in range(2000):
        off = round(20_000 * math.sin(number / 100.0))
        uneven.take(Position(number * 5_000_000 + off, 3.0, 0.0, None))
    rms, most = uneven.unevenness()
    assert rms == pytest.approx(20e-6 / math.sqrt(2.0), rel=0.1)
    assert most == pytest.approx(20e-6, rel=0.2)
    assert (
        uneven.as_metadata(End.AT_REST, {})["stamps_uneven_by_us"] == f"{1e6 * rms:.2g} rms, {1e6 * most:.2g} at most"
    )
