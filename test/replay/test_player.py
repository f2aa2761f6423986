# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Playing: order, rate, loops, the end, and when the next frame is due."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.replay.player import Pace, Player, RateTimer
from cdp_ident.replay.scene import Frame

MODEL = fitted_model(NOMINAL, "test")


class Ramp:
    """A scene in which the inner joint shows the time, the outer one which model is shown, the cart which run it is."""

    def __init__(self, duration):
        self.duration = duration
        self.model, self.run = 0.0, 0.0

    def take_model(self, model, now):
        self.model = now

    def restart(self):
        self.run += 1.0

    def frames(self, times):
        return [Frame(time, (self.run, time, self.model)) for time in times.tolist()]


def times_of(player, count):
    frames = [player.next() for _ in range(count)]
    return [frame.time for frame in frames if frame is not None]


@given(st.floats(1.0, 1000.0), st.floats(0.01, 100.0))
def test_frames_are_evenly_spaced_and_do_not_drift(frequency, rate):
    player = Player(Ramp(np.inf), Pace(frequency, rate))
    assert times_of(player, 2000) == pytest.approx([k * rate / frequency for k in range(2000)], rel=1e-14)


def test_another_rate_goes_on_from_the_next_frame():
    player = Player(Ramp(np.inf), Pace(100.0))
    assert times_of(player, 3) == pytest.approx([0.0, 0.01, 0.02])
    player.take_pace(Pace(100.0, 0.5))
    assert times_of(player, 3) == pytest.approx([0.03, 0.035, 0.04])
    assert player.played == pytest.approx(0.045)


def test_it_ends_with_the_last_frame_that_the_scene_has():
    player = Player(Ramp(0.3), Pace(10.0, loop=False))
    assert times_of(player, 4) == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert not player.finished
    assert player.next() is None
    assert player.finished
    player.restart()
    assert not player.finished
    assert times_of(player, 1) == [0.0]


def test_a_loop_that_is_asked_for_at_the_end_begins_at_once():
    player = Player(Ramp(0.1), Pace(10.0, loop=False))
    assert [frame is None for frame in (player.next(), player.next(), player.next())] == [False, False, True]
    player.take_pace(Pace(10.0))
    assert not player.finished
    assert times_of(player, 1) == [0.0]


def test_a_loop_goes_on_evenly_from_end_to_beginning():
    player = Player(Ramp(0.25), Pace(10.0))
    played = []
    for expected in (0.0, 0.1, 0.2, 0.0, 0.1, 0.2, 0.0):
        played.append(player.played)
        frame = player.next()
        assert frame is not None
        assert frame.time == pytest.approx(expected)
    assert np.diff(played) == pytest.approx([0.1] * 6)


def test_another_model_shows_in_the_very_next_frame():
    player = Player(Ramp(np.inf), Pace(10.0))
    times_of(player, 3)
    player.take_model(MODEL)
    frame = player.next()
    assert frame is not None
    assert (frame.time, frame.simulated[2]) == pytest.approx((0.3, 0.3))


def test_a_restart_is_at_once():
    player = Player(Ramp(np.inf), Pace(10.0))
    times_of(player, 3)
    player.restart()
    frame = player.next()
    assert frame is not None
    assert frame.simulated == (1.0, 0.0, 0.0)


@given(st.floats(1.0, 1000.0), st.lists(st.integers(0, 900_000_000), min_size=1, max_size=50))
def test_deadlines_do_not_drift_however_late_each_is_met(frequency, late):
    timer, begin = RateTimer(frequency), 1_700_000_000_000_000_000
    now = begin
    for count, lateness in enumerate(late):
        deadline = timer.next_ns(now)
        assert deadline == begin + round(count * 1_000_000_000 / Fraction(frequency))
        timer.advance()
        now = deadline + lateness


def test_after_a_second_without_looking_the_count_begins_anew():
    timer = RateTimer(100.0)
    assert timer.next_ns(5) == 5
    timer.advance()
    assert timer.next_ns(8) == 10_000_005
    assert timer.next_ns(2_000_000_000) == 2_000_000_000
    assert timer.next_ns(100) == 100  # the clock was set back


def test_it_can_be_told_to_begin_anew():
    timer = RateTimer(100.0)
    timer.next_ns(0)
    timer.advance()
    timer.begin_anew()
    assert timer.next_ns(123) == 123
