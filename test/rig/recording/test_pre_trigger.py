# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Messages from shortly before a release are kept."""

import pytest

from cdp_ident.rig.recording.pre_trigger import Message, PreTrigger


def received_at(milliseconds: int, size: int = 10) -> Message:
    return Message("/joint_states", "sensor_msgs/msg/JointState", milliseconds * 10**6, bytes(size))


def test_messages_of_the_duration_are_kept_and_older_ones_dropped() -> None:
    kept = PreTrigger(0.5)
    messages = [received_at(time) for time in range(0, 2000, 100)]
    for message in messages:
        kept.keep(message)
    assert list(kept) == messages[-6:]


def test_messages_from_before_the_clock_was_set_back_are_dropped() -> None:
    kept = PreTrigger(1.0)
    for time in (5000, 5100, 1000, 1100):
        kept.keep(received_at(time))
    assert [message.received_ns for message in kept] == [10**9, 11 * 10**8]


def test_messages_are_kept_up_to_a_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cdp_ident.rig.recording.pre_trigger._MOST_BYTES", 100)
    kept = PreTrigger(60.0)
    for time in range(20):
        kept.keep(received_at(time))
    assert len(list(kept)) == 10
    kept.keep(received_at(20, size=200))
    assert not list(kept)
