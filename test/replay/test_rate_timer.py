# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When the next frame is due."""

from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.replay.rate_timer import RateTimer


@given(st.floats(1.0, 1000.0), st.lists(st.integers(0, 900_000_000), min_size=1, max_size=50))
def test_deadlines_do_not_drift_however_late_each_is_met(frequency, late):
    timer, begin = RateTimer(frequency), 1_700_000_000_000_000_000
    now = begin
    for count, lateness in enumerate(late):
        deadline = timer.next_ns(now)
        assert deadline == begin + round(count * 1e9 / frequency)
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
