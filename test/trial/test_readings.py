"""What readings are before they are angles."""

import numpy as np
import pytest

from cdp_ident.trial.readings import alternates, continuous, new_readings, still_publisher

COUNT = 2 * np.pi / 8000
TIME = np.arange(2600) * 0.005
SWING = np.round((np.pi + 1.2 * np.exp(-TIME / 6) * np.sin(6 * TIME)) / COUNT) * COUNT
MOTION = np.column_stack([np.sin(5 * TIME), np.cos(7 * TIME)])


@pytest.mark.parametrize("times", [2, 4, 7])
def test_a_reading_that_is_repeated_in_motion_is_new_once(times):
    new, note = new_readings(np.repeat(SWING[::times], times))
    assert np.array_equal(np.flatnonzero(new), np.arange(0, len(new), times))
    assert "repetitions are left out" in note


@pytest.mark.parametrize("count", [COUNT, 20 * COUNT, 1e-9])
def test_rounding_repeats_readings_in_slow_motion_and_all_are_new(count):
    new, note = new_readings(np.round(SWING / count) * count)
    assert np.all(new)
    assert note == ""


@pytest.mark.parametrize("bits", [8, 10, 11, 16])
def test_a_counter_of_few_bits_is_counted_on_and_known_up_to_its_range(bits):
    counts = np.round(SWING / COUNT - 3900).astype(int)
    readings, size, note = continuous(counts % 2**bits * COUNT)
    assert np.diff(readings) == pytest.approx(np.diff(SWING), abs=1e-9)
    assert size == pytest.approx(2**bits * COUNT)
    assert f"wrap after {2**bits} counts ({bits} bits)" in note


def test_degrees_that_wrap_are_continuous_and_full_turns_and_spikes_stay():
    degrees, size, note = continuous(np.degrees(SWING + 3.0) % 360.0)
    assert size == 0.0
    assert np.ptp(np.diff(degrees)) < 10
    assert note == "wrap after 360"
    spiked = SWING.copy()
    spiked[700] += 9.0
    for readings in (SWING, spiked, (SWING + 3.0) % (2 * np.pi)):
        found, _, note = continuous(readings)
        assert found is readings
        assert note == ""


@pytest.mark.parametrize("every", [1, 4])
def test_one_that_never_moves_is_told_from_the_motion(every):
    places = np.arange(0, len(MOTION), every)
    mixed = np.insert(MOTION, places, [0.0, 0.2], axis=0)
    still, note = still_publisher(mixed)
    assert np.array_equal(mixed[~still], MOTION)
    assert f"its {len(places)} messages are left out" in note


def test_rods_at_rest_whose_readings_flicker_are_no_second_publisher():
    rest = np.zeros((3000, 2))
    rest[::3, 0] = 1e-3
    still, note = still_publisher(np.concatenate([MOTION, rest]))
    assert not np.any(still)
    assert note == ""


def test_two_that_move_alternate_and_one_does_not():
    other = np.column_stack([2 + np.sin(4 * TIME), -1 + np.cos(3 * TIME)])
    mixed = np.stack([MOTION, other], axis=1).reshape(-1, 2)
    assert alternates(mixed)
    assert not alternates(MOTION)
    assert not alternates(np.repeat(MOTION, 3, axis=0))
