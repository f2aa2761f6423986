"""A second publisher on the topic."""

import numpy as np
import pytest

from cdp_ident.trial.publishers import alternates, still_publisher

TIME = np.arange(2000) * 0.005
SWING = np.column_stack([np.sin(5 * TIME), np.cos(7 * TIME)])


@pytest.mark.parametrize("every", [1, 4])
def test_one_that_never_moves_is_told_from_the_motion(every):
    places = np.arange(0, len(SWING), every)
    mixed = np.insert(SWING, places, [0.0, 0.2], axis=0)
    still, note = still_publisher(mixed)
    assert np.array_equal(mixed[~still], SWING)
    assert f"its {len(places)} messages are left out" in note


def test_rods_at_rest_whose_readings_flicker_are_no_second_publisher():
    rest = np.zeros((3000, 2))
    rest[::3, 0] = 1e-3
    still, note = still_publisher(np.concatenate([SWING, rest]))
    assert not np.any(still)
    assert note == ""


def test_two_that_move_alternate_and_one_does_not():
    other = np.column_stack([2 + np.sin(4 * TIME), -1 + np.cos(3 * TIME)])
    mixed = np.empty((4000, 2))
    mixed[::2], mixed[1::2] = SWING, other
    assert alternates(mixed)
    assert not alternates(SWING)
    assert not alternates(np.repeat(SWING, 3, axis=0))
