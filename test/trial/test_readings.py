# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What readings are before they are angles."""

import numpy as np
import pytest

from cdp_ident.errors import TrialError
from cdp_ident.trial.readings import check_publishers, continuous, new_readings, said_again, still_publisher

COUNT = 2 * np.pi / 8000
TIME = np.arange(2600) * 0.005
SWING = np.round((np.pi + 1.2 * np.exp(-TIME / 6) * np.sin(6 * TIME)) / COUNT) * COUNT
MOTION = np.column_stack([np.sin(5 * TIME), np.cos(7 * TIME)])
KNOWN = np.ones(MOTION.shape, dtype=bool)
TURNS = np.full(2, 2 * np.pi)
FLICKER = np.random.default_rng(1).normal(0.0, 1e-3, (650, 2))


@pytest.mark.parametrize("times", [2, 4, 7])
def test_a_reading_that_is_repeated_in_motion_is_new_once(times):
    new, (note,) = new_readings(
        np.repeat(SWING[::times], times)[:, None], np.ones((len(SWING[::times]) * times, 1), bool), TURNS[:1]
    )
    assert np.array_equal(np.flatnonzero(new), np.arange(0, len(new), times))
    assert "repetitions are left out" in note


@pytest.mark.parametrize("rate", [30.0, 60.0, 66.0, 133.0, 166.0])
def test_readings_at_odd_rates_are_as_many_as_were_measured_in_motion_and_at_rest(rate):
    at = np.floor(TIME * rate) / rate
    slow = np.column_stack([np.interp(at, TIME, SWING), np.round(np.exp(-at) * np.sin(9 * at) / COUNT) * COUNT])
    new, notes = new_readings(slow, np.ones(slow.shape, bool), TURNS)
    assert np.array_equal(new[:, 0], new[:, 1])
    assert np.count_nonzero(new[:, 0]) == pytest.approx(rate * TIME[-1], rel=0.05)
    assert all("repetitions are left out" in note for note in notes)


@pytest.mark.parametrize("times", [2, 3, 4])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_joints_that_are_read_in_turn_are_new_in_turn(times, noise):
    measured = MOTION + np.random.default_rng(5).normal(0.0, noise, MOTION.shape)
    row, read = np.arange(len(TIME)), np.array([0, times // 2])
    held = np.maximum((row[:, None] - read) // times * times + read, 0)
    new, notes = new_readings(np.round(np.take_along_axis(measured, held, 0) / COUNT) * COUNT, KNOWN, TURNS)
    right = np.abs(MOTION - MOTION[held, [0, 1]]) == 0.0
    assert np.count_nonzero(new & ~right) < 0.02 * len(TIME)
    assert np.count_nonzero(new, axis=0) == pytest.approx(np.full(2, len(TIME) / times), abs=2)
    assert all("repetitions are left out" in note for note in notes)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_readings_that_repeat_at_random_are_new_once_in_motion(share, noise):
    chance = np.random.default_rng(5)
    fresh = np.insert(chance.random(len(TIME) - 1) > share, 0, True)
    measured = np.round((MOTION + noise * chance.normal(size=MOTION.shape)) / COUNT) * COUNT
    new, notes = new_readings(measured[np.maximum.accumulate(np.arange(len(TIME)) * fresh)], KNOWN, TURNS)
    assert np.count_nonzero(np.any(new, axis=1) & ~fresh) <= 2
    assert np.count_nonzero(fresh & ~np.all(new, axis=1)) < 0.02 * len(TIME)
    assert all("times in motion" in note for note in notes)


@pytest.mark.parametrize(
    "written", [lambda of: of, np.float32, lambda of: np.round(of, 4), lambda of: of % (2 * np.pi)]
)
@pytest.mark.parametrize(("of_inner", "whose"), [(1.0, "less"), (-1.0, "plus")])
@pytest.mark.parametrize("times", [2, 4])
def test_what_is_computed_of_a_fresh_and_a_held_encoder_is_new_when_the_held_one_is(times, of_inner, whose, written):
    inner, outer = np.round(2.0 * MOTION.T / COUNT) * COUNT
    held = outer[np.arange(len(outer)) // times * times]
    readings = np.asarray(written(np.column_stack([inner, held + of_inner * inner])), dtype=float)
    new, notes = new_readings(readings, KNOWN, TURNS)
    assert notes[0] == ""
    assert notes[1].startswith(f"{whose} the inner joint's repeat")
    assert np.all(new[:, 0])
    assert np.count_nonzero(new[np.arange(len(outer)) % times > 0, 1]) < 0.02 * len(outer)
    assert np.count_nonzero(new[::times, 1]) > 0.9 * len(outer) / times
    fresh = np.asarray(written(np.column_stack([inner, outer + of_inner * inner])), dtype=float)
    assert np.all(new_readings(fresh, KNOWN, TURNS)[0])


@pytest.mark.parametrize("count", [COUNT, 20 * COUNT, 1e-9])
def test_rounding_repeats_readings_in_slow_motion_and_all_are_new(count):
    new, notes = new_readings(np.round(SWING / count)[:, None] * count, np.ones((len(SWING), 1), bool), TURNS[:1])
    assert np.all(new)
    assert notes == [""]


@pytest.mark.parametrize("length", [100.0, 400.0])
def test_angles_of_markers_in_whole_pixels_repeat_in_slow_motion_and_all_are_new(length):
    angles = np.arctan2(*np.round(length * np.array([np.sin(SWING), np.cos(SWING)])))[:, None]
    new, notes = new_readings(angles, np.ones(angles.shape, bool), TURNS[:1])
    assert np.all(new)
    assert notes == [""]
    new, (note,) = new_readings(np.repeat(angles[::3], 3, axis=0), np.ones((2601, 1), bool), TURNS[:1])
    assert np.array_equal(np.flatnonzero(new), np.arange(0, 2601, 3))
    assert "repeat 3 times in motion" in note


@pytest.mark.parametrize("rate", [1.0, 0.2])
def test_a_joint_that_strikes_a_stop_and_rests_there_is_measured_all_the_while(rate):
    at = np.arange(0.0, 13.0, 0.005 * rate) % 2.0
    stops = np.select([at < 0.5, at < 1.0, at < 1.5], [(2.0 * at) ** 2, 1.0, 1.0 - (2.0 * at - 2.0) ** 2], 0.0)
    new, notes = new_readings(np.round(stops / COUNT)[:, None] * COUNT, np.ones((len(at), 1), bool), TURNS[:1])
    assert np.all(new)
    assert notes == [""]


@pytest.mark.parametrize("bits", [8, 10, 11, 16])
def test_a_counter_of_few_bits_is_counted_on_and_known_up_to_its_range(bits):
    counts = np.round(SWING / COUNT - 3900).astype(int)
    readings, size, note = continuous(counts % 2**bits * COUNT)
    assert np.diff(readings) == pytest.approx(np.diff(SWING), abs=1e-9)
    assert size == pytest.approx(2**bits * COUNT)
    assert f"wrap after {2**bits} counts ({bits} bits)" in note


@pytest.mark.parametrize(("bits", "turn"), [(8, 360), (8, 1024), (12, 5000), (16, 40_000)])
@pytest.mark.parametrize("digits", [6, 17])
def test_a_counter_s_range_is_known_to_the_count_however_fast_or_coarse_it_is(bits, turn, digits):
    counts = np.round((10.0 + 3.0 * np.sin(9 * TIME)) * turn / (2 * np.pi)).astype(int)
    readings, size, _ = continuous(np.round(counts % 2**bits * 2 * np.pi / turn, digits))
    assert np.diff(readings) * turn / (2 * np.pi) == pytest.approx(np.diff(counts), abs=0.1)
    assert size * turn / (2 * np.pi) == pytest.approx(2**bits, abs=0.1)


@pytest.mark.parametrize("size", [np.pi, 0.9])
def test_readings_that_wrap_after_anything_are_counted_on(size):
    readings, found, note = continuous(2.0 * SWING % size)
    assert np.diff(readings) == pytest.approx(np.diff(2.0 * SWING), abs=2 * COUNT)
    assert found == pytest.approx(size, abs=2 * COUNT)
    assert note.startswith("wrap after")


def test_a_counter_of_32_bits_below_zero_adds_no_rounding():
    readings, _, note = continuous(np.mod(np.round(SWING / COUNT) - 3900, 2.0**32) * COUNT)
    assert np.diff(readings) == pytest.approx(np.diff(SWING), abs=1e-8)
    assert "(32 bits)" in note


def test_degrees_that_wrap_are_continuous_and_full_turns_and_spikes_stay():
    degrees, size, note = continuous(np.degrees(SWING + 3.0) % 360.0)
    assert size == 0.0
    assert np.ptp(np.diff(degrees)) < 10
    assert note == "wrap after 360"
    spiked = SWING.copy()
    spiked[700] += 9.0
    missing = np.where(np.arange(len(SWING)) % 200 == 100, 9999.0, SWING)
    for readings in (SWING, spiked, missing):
        found, _, note = continuous(readings)
        assert found is readings
        assert note == ""
    found, size, note = continuous((SWING + 3.0) % (2 * np.pi))
    assert np.diff(found) == pytest.approx(np.diff(SWING))
    assert (size, note) == (0.0, "")


@pytest.mark.parametrize("every", [2, 4, 20])
def test_what_lies_on_lines_between_measurements_is_none(every):
    number = np.arange(len(MOTION))
    between = np.column_stack([np.interp(number, number[1::every], angle[1::every]) for angle in MOTION.T])
    new, notes = new_readings(between, np.ones_like(between, dtype=bool), TURNS)
    assert np.array_equal(np.flatnonzero(new[:, 0]), number[1::every])
    assert f"between one in {every}: the others are no measurements" in notes[1]
    for whole in (MOTION, np.delete(MOTION, np.s_[1200:1320], axis=0)):
        assert np.all(new_readings(whole, np.ones_like(whole, dtype=bool), TURNS)[0])


@pytest.mark.parametrize("every", [1, 4])
def test_one_that_never_moves_is_told_from_the_motion(every):
    places = np.arange(0, len(MOTION), every)
    mixed = np.insert(MOTION, places, [0.0, 0.2], axis=0)
    still, note = still_publisher(mixed, np.arange(len(mixed)))
    assert np.array_equal(mixed[~still], MOTION)
    assert f"its {len(places)} messages are left out" in note


def test_rods_at_rest_whose_readings_flicker_are_no_second_publisher():
    rest = np.zeros((3000, 2))
    rest[::3, 0] = 1e-3
    readings = np.concatenate([MOTION, rest])
    still, note = still_publisher(readings, np.arange(len(readings)))
    assert not np.any(still)
    assert note == ""


def test_rods_at_rest_that_are_stored_out_of_order_are_no_second_publisher():
    readings = np.concatenate([np.full((len(MOTION) // 5, 2), 0.2), MOTION])
    order = np.random.default_rng(2).permutation(len(readings))
    assert not np.any(still_publisher(readings[order], order)[0])
    assert np.any(still_publisher(readings[order], np.arange(len(readings)))[0])


def test_two_that_move_alternate_and_one_does_not():
    other = np.column_stack([2 + np.sin(4 * TIME), -1 + np.cos(3 * TIME)])
    mixed = np.stack([MOTION, other], axis=1).reshape(-1, 2)
    for two in (mixed, np.insert(MOTION, np.arange(0, len(MOTION), 4), FLICKER, axis=0)):
        with pytest.raises(TrialError, match="samples on /states alternate between two motions"):
            check_publishers(two, 0.005 * np.arange(len(two)), "/states")
    for one in (MOTION, np.repeat(MOTION, 3, axis=0)):
        check_publishers(one, 0.005 * np.arange(len(one)), "/states")


@pytest.mark.parametrize("step", [1e-9, COUNT, 2 * np.pi / 400])
def test_what_a_swing_s_encoders_read_is_not_said_again_though_they_flicker_at_rest(step):
    moving = np.column_stack([SWING, np.exp(-TIME / 8) * np.cos(9 * TIME)])
    still = np.random.default_rng(1).integers(0, 2, (4000, 2)) * step
    readings = np.concatenate([still, np.round(moving / step) * step, still])
    again, words = said_again(readings)
    assert (np.any(again), words) == (False, "")


def test_nothing_is_not_said_again():
    assert said_again(np.empty((0, 2)))[1] == ""
