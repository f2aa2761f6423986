# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The device's own time in bags."""

import numpy as np
import pytest

from cdp_ident.bag import diagnostics as diagnostics_module
from cdp_ident.bag import time_reference as time_reference_module
from cdp_ident.bag.diagnostics import CLOCK_RATE, CLOCK_RATE_STD
from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.reader import read_joint_states
from cdp_ident.bag.writer import BagWriter
from scenarios.device_messages import diagnostics, time_reference

EPOCH = 1_700_000_000_000_000_000
STAMPS = EPOCH + 5_000_000 * np.arange(100)
DEVICE = 7_000_000_000 + 5_000_001 * np.arange(100)
RATES = {"one": "10.0", "other": "20.0"}


def bag(folder, references, statuses=()):
    """Write joint states at STAMPS, time references (topic, stamp, device, source) and the rates of some devices."""
    with BagWriter(folder) as writer:
        for stamp in STAMPS.tolist():
            writer.write("/joint_states", MESSAGE_TYPE, stamp, serialize_joint_state(["a", "b"], [1.0, 2.0], stamp))
        for topic, stamp, device, source in references:
            raw = time_reference(stamp, device, source)
            writer.write(topic, time_reference_module.MESSAGE_TYPE, stamp, raw)
        for source in statuses:
            values = {CLOCK_RATE: RATES[source], CLOCK_RATE_STD: "0.5"}
            raw = diagnostics({"/driver": values}, source)
            writer.write("/diagnostics", diagnostics_module.MESSAGE_TYPE, EPOCH, raw)
    return read_joint_states(folder, "joint_states")


def test_each_sample_has_the_device_s_time_and_the_rate_is_that_device_s(tmp_path):
    references = [("/time_reference", s, d, "one") for s, d in zip(STAMPS.tolist(), DEVICE.tolist(), strict=True)]
    recording = bag(tmp_path / "bag", reversed(references), ["other", "one", "other"])
    assert np.array_equal(recording.device, DEVICE)
    assert recording.device_rate == pytest.approx((10e-6, 0.5e-6))


def test_a_few_samples_without_it_are_dropped(tmp_path):
    references = [("/time_reference", s, d, "one") for s, d in zip(STAMPS.tolist(), DEVICE.tolist(), strict=True)]
    recording = bag(tmp_path / "bag", references[3:-1])
    assert np.array_equal(recording.stamps, STAMPS[3:-1])
    assert len(recording.positions) == len(recording.device) == 96
    assert recording.device_rate is None
    assert recording.notes == ("4 samples without the device's own time are dropped",)


def test_time_references_of_something_else_are_left_alone(tmp_path):
    references = [("/gps/time", s + 1000, d, "gps") for s, d in zip(STAMPS.tolist(), DEVICE.tolist(), strict=True)]
    recording = bag(tmp_path / "bag", references)
    assert recording.device is None
    assert len(recording.stamps) == 100


def test_of_two_rigs_it_is_that_of_the_samples(tmp_path):
    other = [("/rig2/time_reference", s + 77, 0, "other") for s in STAMPS.tolist()]
    own = [("/rig1/time_reference", s, d, "one") for s, d in zip(STAMPS.tolist(), DEVICE.tolist(), strict=True)]
    recording = bag(tmp_path / "bag", other + own, ["one", "other"])
    assert np.array_equal(recording.device, DEVICE)
    assert recording.device_rate == pytest.approx((10e-6, 0.5e-6))
