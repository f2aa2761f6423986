# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recordings of a simulated pendulum in a simulated hand."""

import itertools

import numpy as np
import pytest

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients

START = 1_700_000_000_000_000_000
RATE = 200.0
COUNTS = 8000
BRISK = {**NOMINAL, "c1": 0.002, "c2": 0.0005}
"""Table 2's pendulum with good bearings: it swings long enough for two trials."""


class Recording:
    """What a hand and gravity do one after the other, as the encoders see it."""

    def __init__(self, parameters=BRISK, rate=RATE):
        self.values = parameters
        self.coefficients = physical_coefficients(parameters)
        self.rate = rate
        self.state = np.array([np.pi, np.pi, 0.0, 0.0])
        self.theta = [self.state[None, :2]]

    @property
    def now(self):
        return sum(len(part) for part in self.theta) / self.rate

    def hold(self, seconds):
        """The hand holds the rods where they are."""
        self.state[2:] = 0
        self.theta.append(np.tile(self.state[:2], (round(seconds * self.rate), 1)))
        return self

    def carry(self, theta1, theta2, seconds):
        """The hand carries the rods to another posture."""
        s = np.arange(1, round(seconds * self.rate) + 1)[:, None] / round(seconds * self.rate)
        self.theta.append(self.state[:2] + (np.array([theta1, theta2]) - self.state[:2]) * (3 * s**2 - 2 * s**3))
        self.state = np.array([theta1, theta2, 0.0, 0.0])
        return self

    def swing(self, seconds, omega=(0.0, 0.0)):
        """Nothing but gravity and friction acts; omega is what the hand leaves the rods with."""
        start = self.state + np.array([0, 0, *omega])
        states = simulate(self.coefficients, start, np.arange(round(seconds * self.rate) + 1) / self.rate)
        self.theta.append(states[1:, :2])
        self.state = states[-1].copy()
        return self

    def joints(self, noise=0.0, seed=1):
        """Positions of the inner joint and the outer one relative to it (n, 2), in encoder counts' steps [rad]."""
        theta = np.concatenate(self.theta)
        relative = np.column_stack([theta[:, 0], theta[:, 1] - theta[:, 0]])
        relative = relative + np.random.default_rng(seed).normal(0, noise, relative.shape)
        return np.round(relative * COUNTS / (2 * np.pi)) * (2 * np.pi) / COUNTS

    def stamps(self):
        return START + np.round(np.arange(sum(len(part) for part in self.theta)) * 1e9 / self.rate).astype(np.int64)


@pytest.fixture(scope="session")
def recording():
    return Recording


@pytest.fixture(scope="session")
def swing():
    return Recording().carry(2.0, 2.5, 1.0).hold(0.5).swing(10)


@pytest.fixture
def make_bag(tmp_path):
    """Write positions (n, joints) at stamps (n,) into a new bag and return it."""
    number = itertools.count()

    def write(stamps, positions, names=("inner_joint", "outer_joint"), topic="/joint_states"):
        bag = tmp_path / f"swing{next(number)}"
        with BagWriter(bag) as writer:
            writer.add_topic(topic, MESSAGE_TYPE)
            for i, (stamp, position) in enumerate(zip(stamps.tolist(), positions, strict=True)):
                writer.write(topic, MESSAGE_TYPE, START + i, serialize_joint_state(names, position, stamp))
        return bag

    return write
