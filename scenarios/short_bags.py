# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags of a few messages, for those who read bags."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer

from cdp_ident.arrays import Array, Indices
from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state, typestore
from cdp_ident.bag.writer import BagWriter

NAMES = ("inner_joint", "outer_joint")
START = 1_700_000_000_000_000_000
PERIOD = 5_000_000
COUNT = 60
STAMPS = START + PERIOD * np.arange(COUNT)
POSITIONS = np.column_stack([np.linspace(0, 1, COUNT), np.linspace(3, -3, COUNT)])


def fill(
    bag: Path,
    stamps: Indices = STAMPS,
    positions: Array = POSITIONS,
    names: Sequence[str] = NAMES,
    delay: int = 1000,
    topic: str = "/joint_states",
) -> Path:
    """Write a bag of joint states, each in a chunk of its own, received `delay` [ns] after its stamp; return it."""
    with BagWriter(bag) as writer:
        for stamp, position in zip(stamps.tolist(), positions, strict=True):
            receipt = (stamp or START) + delay
            writer.write(topic, MESSAGE_TYPE, receipt, serialize_joint_state(names, position, stamp))
            writer.flush()
    return bag


def fill_sqlite(bag: Path, count: int = COUNT) -> Path:
    """Write the first joint states by another writer, into a database; return the bag."""
    with Writer(bag, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection("/joint_states", MESSAGE_TYPE, typestore=typestore())
        for stamp, position in zip(STAMPS[:count].tolist(), POSITIONS[:count], strict=True):
            writer.write(connection, stamp, serialize_joint_state(NAMES, position, stamp))
    return bag


def publish(bag: Path, *messages: bytes, topic: str = "/joint_states") -> Path:
    """Write messages as they are, each in a chunk of its own; return the bag."""
    with BagWriter(bag) as writer:
        for raw in messages:
            writer.write(topic, MESSAGE_TYPE, START, raw)
            writer.flush()
    return bag


def expect_all(recording: JointRecording) -> None:
    """Assert that a recording has all that `fill` writes, and nothing to say of it."""
    assert recording.joints == NAMES
    assert np.array_equal(recording.stamps, STAMPS)
    assert np.array_equal(recording.positions, POSITIONS)
    assert recording.notes == ()
