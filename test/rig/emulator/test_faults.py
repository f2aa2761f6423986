# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The cable with faults."""

import numpy as np
import pytest

from cdp_ident.rig.emulator.faults import Faults, Line


def drive(faults, seconds=20.0):
    """Send 100 bytes every 10 ms; return what was sent, what arrived, and how late each 10 ms was."""
    line = Line(faults, np.random.default_rng(1))
    sent, arrived, times = b"", b"", []
    for step in range(int(seconds * 100)):
        data = bytes([step % 251]) * 100
        sent += data
        line.send(data, step * 0.01)
        arrived += line.receive(step * 0.01)
        times.append((len(sent) - len(arrived)) / 10_000)
    return sent, arrived + line.receive(1e9), times


def test_a_good_cable_changes_nothing():
    sent, arrived, late = drive(Faults())
    assert arrived == sent
    assert max(late) == 0.0


def test_flips_are_as_frequent_as_told_and_of_one_bit():
    sent, arrived, _ = drive(Faults(flips=0.01))
    changed = np.frombuffer(sent, np.uint8) ^ np.frombuffer(arrived, np.uint8)
    assert np.mean(changed > 0) == pytest.approx(0.01, rel=0.1)
    assert all(int(bits).bit_count() == 1 for bits in changed[changed > 0])


def test_losses_are_as_frequent_as_told():
    sent, arrived, _ = drive(Faults(losses=0.02))
    assert len(arrived) / len(sent) == pytest.approx(0.98, abs=0.002)


def test_bursts_add_bytes():
    sent, arrived, _ = drive(Faults(bursts=1.0))
    assert 500 < len(arrived) - len(sent) < 5000


def test_a_delay_gathers_batches_and_loses_nothing():
    sent, arrived, late = drive(Faults(delay=0.1))
    assert arrived == sent
    assert 0.05 < max(late) <= 0.11


def test_a_stall_holds_everything_back_and_then_gives_it():
    sent, arrived, late = drive(Faults(stall_every=5.0, stall_for=1.0))
    assert arrived == sent
    assert max(late) == pytest.approx(1.0, abs=0.02)
    assert late[480] == 0.0
