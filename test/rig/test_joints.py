# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Counts to positions: scale, sign, roll-over, impossible jumps, and the zero in its file."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import RigError
from cdp_ident.rig.joints import Calibration, JointTracker, Zero, load_zero, save_zero
from cdp_ident.rig.protocol import Hello, Sample

CALIBRATION = Calibration(metres_per_count=1e-4, inner_counts_per_turn=4000, outer_counts_per_turn=8000)
AS_FAST_AS_IT_LIKES = replace(CALIBRATION, cart_slew_limit=1e9, inner_slew_limit=1e9, outer_slew_limit=1e9)
COUNTS = st.integers(-(2**31), 2**31 - 1)


def sample(step, cart=0, inner=0, outer=0):
    def wrapped(count):
        return (count + 2**31) % 2**32 - 2**31

    return Sample(step, step * 1000, wrapped(cart), wrapped(inner), wrapped(outer))


def tracker(calibration=CALIBRATION, zero=(0.0, 0.0, 0.0)):
    return JointTracker(calibration.scales(None), calibration, zero)


def test_the_zero_is_hanging_and_a_turn_is_the_counts_per_turn():
    joints = tracker(AS_FAST_AS_IT_LIKES, (10.0, -20.5, 30.0))
    assert joints.positions(sample(0, 10, -20, 30)) == pytest.approx((0.0, math.pi + math.tau * 0.5 / 4000, 0.0))
    assert joints.positions(sample(1, 110, 3980, -7970)) == pytest.approx(
        (0.01, math.pi + math.tau * 4000.5 / 4000, -math.tau)
    )


def test_signs_turn_directions_round():
    joints = tracker(replace(CALIBRATION, cart_sign=-1, inner_sign=-1, outer_sign=-1))
    assert joints.positions(sample(0, 100, 2, 4)) == pytest.approx(
        (-0.01, math.pi - math.tau * 2 / 4000, -math.tau * 4 / 8000)
    )


@given(zero=st.tuples(COUNTS, COUNTS, COUNTS), steps=st.lists(st.integers(-300, 300), min_size=1, max_size=50))
def test_positions_do_not_notice_that_counters_roll_over(zero, steps):
    joints = tracker(
        zero=(float(zero[0]), float(zero[1]), float(zero[2])),
        calibration=AS_FAST_AS_IT_LIKES,
    )
    moved = 0
    for number, step in enumerate(steps):
        moved += step
        positions = joints.positions(sample(number, zero[0] + moved, zero[1] + moved, zero[2] - moved))
        assert positions == pytest.approx(
            (1e-4 * moved, math.pi + math.tau * moved / 4000, -math.tau * moved / 8000), abs=1e-9
        )


@pytest.mark.parametrize(
    ("counts", "dropped"),
    [
        # What follows one impossible jump is untouched, one that lasts is believed after three samples, …
        ([0, 1, 2000, 2, 3], [2]),
        ([0, 1, 2000, 2001, 2002, 2003], [2, 3]),
        # … and of those that never agree all are dropped.
        ([0, 5000, -9000, 700_000, 3, -80_000, 4], [1, 2, 3, 5]),
    ],
)
def test_impossible_jumps_are_dropped_until_they_last(counts, dropped):
    joints = tracker()
    inner = [joints.positions(sample(step, inner=count)) for step, count in enumerate(counts)]
    assert [step for step, position in enumerate(inner) if position is None] == dropped
    assert inner[-1] == pytest.approx((0.0, math.pi + math.tau * counts[-1] / 4000, 0.0))


def test_resting_counts_are_the_mean_of_the_last_second():
    joints = tracker()
    for step in range(3000):
        joints.positions(sample(step, 7, 100 + step // 1500, step % 2))
    assert joints.resting_counts() == pytest.approx((7.0, 101.0, 0.5), abs=1e-3)


def test_zeroing_is_refused_while_a_joint_moves_and_the_message_says_which_and_how_far():
    joints = tracker()
    for step in range(1500):
        joints.positions(sample(step, outer=step // 40))
    with pytest.raises(RigError, match=r"outer joint moved by 0\.0\d+ rad.*limit 0\.01 rad"):
        joints.resting_counts()


def test_zeroing_is_refused_before_a_second_was_seen():
    joints = tracker()
    with pytest.raises(RigError, match="less than 1 s"):
        joints.resting_counts()
    for step in range(500):
        joints.positions(sample(step))
    with pytest.raises(RigError, match="less than 1 s"):
        joints.resting_counts()


def test_the_greeting_tells_the_counts_that_the_user_did_not():
    hello = Hello(1000, 500, 600, "")
    half = replace(CALIBRATION, outer_counts_per_turn=0)
    assert half.counts_per_turn(hello) == (4000, 600)
    assert half.needs_greeting()
    assert not CALIBRATION.needs_greeting()
    with pytest.raises(RigError, match="no greeting"):
        half.scales(None)


ZERO = Zero(1.5, -2.25, 1e9, 4_000_000_000, 1_760_000_000_000_000_000)


def test_a_zero_is_kept(tmp_path):
    path = tmp_path / "new" / "zero.yaml"
    save_zero(path, Zero(0.0, 0.0, 0.0, 1, 2))
    save_zero(path, ZERO)
    assert load_zero(path) == ZERO
    assert list(path.parent.iterdir()) == [path]


def test_no_file_is_no_zero(tmp_path):
    assert load_zero(tmp_path / "zero.yaml") is None


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"[1, 2]",
        b"cart_counts: 1\n",
        b"{cart_counts: x, inner_counts: 0, outer_counts: 0, sequence: 0, taken_at_ns: 0}",
        b"{cart_counts: .nan, inner_counts: 0, outer_counts: 0, sequence: 0, taken_at_ns: 0}",
    ],
)
def test_a_damaged_file_is_refused_with_what_to_do(tmp_path, content):
    path = tmp_path / "zero.yaml"
    path.write_bytes(content)
    with pytest.raises(RigError, match=r"(?s)zero\.yaml.*delete it"):
        load_zero(path)


def test_a_place_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RigError, match="cannot be kept"):
        save_zero(tmp_path / "file" / "zero.yaml", ZERO)


@pytest.mark.parametrize(
    ("sequence", "seconds", "same"),
    [
        (4_000_000_000, 0.0, True),
        (4_000_060_000, 60.0, True),
        ((4_000_000_000 + 86_400_000) % 2**32, 86_400.2, True),
        ((4_000_000_000 + 864_000_000) % 2**32, 864_000.0, True),
        (100, 60.0, False),
        (0, 1.0, False),
        (4_000_060_000, 600.0, False),
        (4_000_060_000, -60.0, False),
    ],
)
def test_the_sequence_number_tells_whether_the_device_ran_on(sequence, seconds, same):
    assert ZERO.is_of_this_run(sequence, ZERO.taken_at_ns + round(seconds * 1e9), 1000) is same
