# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from reference import encoders
from reference.dry_friction import DryFriction
from reference.encoders import Counter, Turned, joint_angles, theta_of
from reference.mechanics import Rig
from reference.pendulum import TABLE_5
from reference.plant import Plant
from reference.sticking import path

TIMES = np.arange(400) / 200.0


@pytest.fixture(scope="module")
def turned():
    """What encoders turn by: computed by a test and not when tests are collected, for that may compile first."""
    moved = path(Plant(Rig(TABLE_5)), (3.9, 4.4, 0.0, 0.0), TIMES)
    return Turned(TABLE_5, moved, joint_angles(moved))


def test_the_joints_angles_and_the_paper_s_are_the_same_in_other_words(turned):
    assert theta_of(turned.joints) == pytest.approx(turned.path.states[:, :2], abs=1e-14)


@pytest.mark.parametrize(
    ("reading", "column", "expected"),
    [
        (encoders.offset("inner", 0.01), 0, lambda angle: 0.01),
        (encoders.offset("outer", 0.01), 1, lambda angle: 0.01),
        (encoders.scale("inner", 0.02), 0, lambda angle: 0.02 * angle),
        (encoders.eccentricity("outer", 0.01, 0.5), 1, lambda angle: 0.01 * np.sin(angle + 0.5)),
        (encoders.slip("outer", -0.03, 1.0), 1, lambda angle: np.where(TIMES < 1.0, 0.0, -0.03)),
    ],
)
def test_an_error_is_added_to_its_own_encoder_alone(turned, reading, column, expected):
    added = reading(turned)
    assert added[:, column] == pytest.approx(np.broadcast_to(expected(turned.joints[:, column]), 400), abs=1e-15)
    assert not added[:, 1 - column].any()


def test_play_holds_on_until_it_is_used_up(turned):
    inner = turned.joints[:, 0]
    shown = inner + encoders.backlash("inner", 0.02)(turned)[:, 0]
    assert np.abs(shown - inner).max() == pytest.approx(0.02)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(inner))))
    assert len(turns) > 1
    assert shown[turns[0] + 1] == shown[turns[0] + 2]


def test_a_rod_at_rest_is_bent_by_the_weight_at_its_end():
    leaning = (math.pi + 0.4, math.pi, 0.0, 0.0)
    values = {**TABLE_5, "m0": 1e-9}
    held = path(Plant(Rig(values), DryFriction(10.0), DryFriction(10.0)), leaning, TIMES)
    bent = encoders.rod_flex(0.01)(Turned(values, held, joint_angles(held)))
    slope = 0.01 * values["m2"] * values["g"] * math.sin(0.4) / values["L"]
    assert bent[-1] == pytest.approx([-slope * np.sign(-0.4), -0.5 * slope * np.sign(-0.4)], rel=1e-6)


def test_counts_are_whole_and_their_error_is_as_said(turned):
    counter = Counter(2000, 1e-4)
    counted = counter.count(turned.joints, np.random.default_rng(0))
    counts = counted / (2 * math.pi / 2000)
    assert counts == pytest.approx(np.round(counts), abs=1e-9)
    assert np.std(counted - turned.joints) == pytest.approx(counter.error, rel=0.05)


def test_correlated_noise_has_its_correlation_and_the_same_variance():
    joints = np.zeros((200_000, 2))
    noise = Counter(10**9, 1e-3, memory=0.8).count(joints, np.random.default_rng(0))[:, 0]
    assert np.std(noise) == pytest.approx(1e-3, rel=0.02)
    assert np.corrcoef(noise[1:], noise[:-1])[0, 1] == pytest.approx(0.8, abs=0.01)


def test_noise_that_is_remembered_is_of_the_same_size_from_the_first_sample_on():
    counter = Counter(10**9, 1e-3, memory=0.9)
    noise = counter.count(np.zeros((20, 2000)), np.random.default_rng(0))
    assert np.std(noise, axis=1) == pytest.approx(1e-3, rel=0.1)
    assert np.mean(noise[5] * noise[0]) / 1e-6 == pytest.approx(0.9**5, abs=0.08)
