# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is said about a trial; when it begins and ends, on motions of the model and of a shaky hand."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.bag.joint_state import serialize_joint_state
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.rig.emulator.motion import Hold, LetGo, Motion, Wait
from cdp_ident.rig.recording.detector import End, EndDetector, ReleaseDetector, SlidingRange, TrialLimits
from cdp_ident.rig.recording.facts import JointNames, Position, PositionReader, RecorderOptions, TrialFacts


def facts(count=2000, cart_step=0.0, missing=frozenset()):
    result = TrialFacts(RecorderOptions(), 1_000_000_000, started_by_hand=False)
    for number in range(count):
        if number not in missing:
            stamp = number * 5_000_000
            cart = 0.5 if stamp < 1_000_000_000 else cart_step * number
            result.take(Position(stamp, 3.0, 0.0, cart))
    return result


def test_a_good_trial_has_no_warnings():
    good = facts()
    assert good.warnings() == []
    metadata = good.as_metadata(End.AT_REST)
    assert metadata["cart_at_rest"] == "true"
    assert (metadata["samples"], metadata["samples_lost"], metadata["duration_s"]) == ("2000", "0", "8.995")
    of_recorder = {"pre_trigger": 1.0, "cart_limit": 0.002, "shortest": 5.0}
    assert json.loads(metadata["parameters"]) == vars(TrialLimits()) | of_recorder
    assert all(isinstance(value, str) for value in metadata.values())


def test_stamps_that_went_back_are_said():
    set_back = facts()
    set_back.take(Position(9_800_000_000, 3.0, 0.0, None))
    assert set_back.warnings() == ["the stamps went back 1 times"]


def test_a_cart_that_is_not_measured_is_not_said_to_be_at_rest():
    result = TrialFacts(RecorderOptions(), 0, started_by_hand=True)
    result.take(Position(0, 3.0, 0.0, None))
    assert result.as_metadata(End.STOPPED)["cart_at_rest"] == "not measured"


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
    uneven = TrialFacts(RecorderOptions(), 0, started_by_hand=False)
    for number in range(2000):
        off = round(20_000 * math.sin(number / 100.0))
        uneven.take(Position(number * 5_000_000 + off, 3.0, 0.0, None))
    rms, most = uneven.unevenness()
    assert rms == pytest.approx(20e-6 / math.sqrt(2.0), rel=0.1)
    assert most == pytest.approx(20e-6, rel=0.2)
    assert uneven.as_metadata(End.AT_REST)["stamps_uneven_by_us"] == f"{1e6 * rms:.2g} rms, {1e6 * most:.2g} at most"


PERIOD = 0.005
COEFFICIENTS = physical_coefficients(NOMINAL)


def joints(*script, tremor=0.0):
    """Return inner and outer joint [rad] at 200 Hz for a script, with a hand's slow tremor added before the end."""
    lasting = sum(
        command.seconds if isinstance(command, Wait) else getattr(command, "within", 0.0) for command in script
    )
    samples = Motion(COEFFICIENTS, script, PERIOD).advance(round(lasting / PERIOD))
    shake = tremor * np.sin(np.arange(len(samples)) * PERIOD * 2 * math.pi * 3.0)
    return np.column_stack([samples[:, 1] + shake, samples[:, 2] - samples[:, 1]])


def first_release(angles):
    detector = ReleaseDetector(TrialLimits())
    for number, (inner, outer) in enumerate(angles):
        if detector.update(round(number * PERIOD * 1e9), inner, outer):
            return number * PERIOD
    return None


def end(angles, limits=None):
    detector = EndDetector(limits or TrialLimits(), 0)
    for number, (inner, outer) in enumerate(angles):
        if (why := detector.update(round(number * PERIOD * 1e9), inner, outer)) is not None:
            return why, number * PERIOD
    return None, len(angles) * PERIOD


@pytest.mark.parametrize("tremor", [0.0, 0.01])
@pytest.mark.parametrize(("theta1", "theta2"), [(1.0, 1.0), (math.pi, 2.0), (0.0, 0.0), (-2.6, 2.9), (3.4, 3.4)])
def test_a_release_is_noticed_within_a_third_of_a_second(theta1, theta2, tremor):
    push = Hold(theta1 + 0.02, theta2 + 0.02, 0.2)  # a hand that lets go at the very top would see it stay there
    angles = joints(Wait(1.0), Hold(theta1, theta2), Wait(2.0), push, LetGo(), Wait(3.0), tremor=tremor)
    released = first_release(angles)
    assert released is not None
    assert 4.5 < released < 5.7 if theta1 == 0.0 else 4.7 < released < 5.1


def test_leading_the_pendulum_about_and_hanging_still_are_no_release():
    angles = joints(Wait(2.0), Hold(1.0, 1.0, 2.0), Wait(1.0), tremor=0.005)
    assert first_release(angles) is None


def test_putting_it_back_slowly_is_no_release():
    angles = joints(Hold(1.0, 1.0, 2.0), Wait(1.0), Hold(math.pi, math.pi, 25.0), Wait(1.0))
    assert first_release(angles) is None


def test_the_end_is_a_second_of_rest():
    heavy = physical_coefficients(NOMINAL | {"c1": 0.1, "c2": 0.05})
    motion = Motion(heavy, (Hold(2.0, 2.0, 0.1), LetGo(), Wait(60.0)), PERIOD)
    samples = motion.advance(8000)
    angles = np.column_stack([samples[:, 1], samples[:, 2] - samples[:, 1]])
    why, when = end(angles)
    assert why is End.AT_REST
    last = round(when / PERIOD)
    assert np.ptp(angles[last - 200 : last + 1], axis=0).max() <= 0.01
    assert np.ptp(angles[last - 201 : last], axis=0).max() > 0.01


def test_started_by_hand_it_does_not_end_before_anything_moved():
    why, when = end(joints(Wait(10.0)))
    assert why is None
    assert when == pytest.approx(10.0, abs=0.01)


CAUGHT = (Hold(2.0, 2.0, 0.5), Wait(1.0), LetGo(), Wait(3.0), Hold(2.5, 2.5, 0.7), Wait(3.0))


def test_a_hand_that_catches_the_rods_and_holds_them_is_an_end():
    angles = joints(*CAUGHT, tremor=0.003)
    why, when = end(angles[round(1.6 / PERIOD) :])
    assert why is End.CAUGHT
    assert when + 1.6 == pytest.approx(6.2, abs=0.2)


def test_started_by_hand_only_rest_ends_it():
    detector = EndDetector(TrialLimits(), 0, ends_when_caught=False)
    ends = [detector.update(round(n * PERIOD * 1e9), *angles) for n, angles in enumerate(joints(*CAUGHT).tolist())]
    assert set(ends) == {None}


def test_a_trial_does_not_last_longer_than_it_may():
    why, when = end(joints(Wait(5.0)), TrialLimits(longest=3.0))
    assert why is End.TIME_OUT
    assert when == pytest.approx(3.0, abs=0.01)


def test_a_sliding_range_is_what_it_says():
    generator = np.random.default_rng(5)
    stamps = np.cumsum(generator.integers(1, 9, 400)) * 10_000_000
    values = generator.normal(size=400)
    window = SlidingRange(0.5)
    for number, (stamp, value) in enumerate(zip(stamps.tolist(), values.tolist(), strict=True)):
        recent = values[: number + 1][stamps[: number + 1] >= stamp - 500_000_000]
        expected = np.ptp(recent) if stamp - stamps[0] >= 500_000_000 else math.inf
        assert window.update(stamp, value) == expected


@pytest.mark.parametrize("L", [0.1, 0.4, 1.0, 2.0])
@pytest.mark.parametrize("seed", range(3))
def test_no_turning_point_of_a_swing_is_a_release(L, seed):
    generator = np.random.default_rng(seed)
    scale = L / NOMINAL["L"]
    own = {"L": L, **{s: NOMINAL[s] * scale for s in ("l1", "l2")}, **{s: NOMINAL[s] * scale**2 for s in ("J1", "J2")}}
    damping = {s: NOMINAL[s] * scale**1.5 for s in ("c1", "c2")}
    theta = math.pi + generator.uniform(-1.5, 1.5, 2)
    motion = Motion(physical_coefficients(NOMINAL | own | damping), (Hold(*theta, 0.1), LetGo(), Wait(60.0)), PERIOD)
    motion.advance(round(0.2 / PERIOD))
    samples = motion.advance(round(60.0 / PERIOD))
    assert first_release(np.column_stack([samples[:, 1], samples[:, 2] - samples[:, 1]])) is None


def seen(angles, missing=0.0, jump=0.0, at=1.0):
    """Return stamps [ns] and angles; from a time on some are missing for so long, or the stamps jump by so much [s]."""
    times = np.arange(len(angles)) * PERIOD
    kept = (times < at) | (times >= at + missing)
    stamps = np.round((times + jump * (times >= at)) * 1e9).astype(np.int64)[kept]
    return list(zip(stamps.tolist(), *angles[kept].T.tolist(), strict=True))


@pytest.mark.parametrize(
    ("missing", "jump"), [(0.35, 0.0), (1.05, 0.0), (4.0, 0.0), (0.0, 0.4), (0.0, 1.05), (0.0, -0.4), (0.0, -3600.0)]
)
def test_samples_that_are_missing_and_stamps_that_jump_are_no_stillness(missing, jump):
    swing = joints(Hold(2.0, 2.0, 0.1), LetGo(), Wait(8.0))
    for at in np.arange(1.0, 2.5, 0.05).tolist():
        release, end = ReleaseDetector(TrialLimits()), EndDetector(TrialLimits(), 0)
        for stamp, inner, outer in seen(swing, missing, jump, at):
            assert not release.update(stamp, inner, outer)
            assert end.update(stamp, inner, outer) is None


def test_a_motion_of_which_nothing_is_seen_for_longer_than_the_limit_has_ended():
    swing, detector = joints(Hold(2.0, 2.0, 0.1), LetGo(), Wait(8.0)), EndDetector(TrialLimits(silence=2.0), 0)
    ends = [detector.update(*sample) for sample in seen(swing, missing=2.1)]
    assert ends.index(End.SILENCE) == 200


@pytest.mark.parametrize(("missing", "jump"), [(0.4, 0.0), (0.0, 0.5), (0.0, -0.5), (0.0, -3600.0)])
@pytest.mark.parametrize("at", [1.6, 2.0, 2.3, 2.45])
def test_a_release_after_a_hold_of_which_samples_are_missing_is_noticed(missing, jump, at):
    hold = joints(Wait(1.0), Hold(1.5, 1.5, within=0.5), Wait(1.5), LetGo(), Wait(1.0))
    detector = ReleaseDetector(TrialLimits())
    found = [stamp * 1e-9 - jump for stamp, *angles in seen(hold, missing, jump, at) if detector.update(stamp, *angles)]
    assert found == pytest.approx([3.1], abs=0.15)


def test_a_trial_that_time_was_set_back_in_lasts_no_longer_than_others():
    detector = EndDetector(TrialLimits(longest=3.0), 0)
    ends = [detector.update(*sample) for sample in seen(joints(Wait(5.0)), jump=-3600.0, at=2.0)]
    assert ends.index(End.TIME_OUT) * PERIOD == pytest.approx(3.0, abs=0.02)
