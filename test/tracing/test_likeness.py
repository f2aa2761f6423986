# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Known shapes are recognised in nonparametric torques."""

import numpy as np
import pytest

from cdp_ident.tracing.likeness import likeness

ANGLES = np.linspace(-1.5, 1.8, 120)
SPEEDS = np.linspace(-6.0, 7.0, 120)


def with_noise(torque):
    return torque + np.random.default_rng(0).normal(scale=0.05 * np.sqrt(np.mean(torque**2)), size=len(torque))


@pytest.mark.parametrize(
    ("torque", "words"),
    [
        (0.3 - 2.0 * ANGLES, "a spring or a cable"),
        (0.1 * np.sin(ANGLES + 0.4), "an unbalance"),
        (-5.0 * np.maximum(ANGLES - 1.2, 0.0), "an end stop at 1.2 rad"),
        (0.1 * np.sin(5.0 * ANGLES + 0.4), "detents, 5 a turn,"),
        (-(ANGLES - 0.1) * np.exp(-0.5 * ((ANGLES - 0.1) / 0.15) ** 2), "a magnet at 0.1 rad"),
    ],
    ids=["spring", "unbalance", "end stop", "detents", "magnet"],
)
def test_a_torque_over_the_angle_is_like(torque, words):
    assert likeness("angle", False, ANGLES, with_noise(torque)).split(" at ")[0] == words.split(" at ")[0]
    if " at " in words:
        place = float(likeness("angle", False, ANGLES, torque).split()[-2])
        assert place == pytest.approx(float(words.split()[-2]), abs=0.1)


def test_friction_over_a_part_of_the_turn_is_like_a_part_that_rubs():
    part = (np.abs(ANGLES - 0.4) < 0.3).astype(float)
    found = likeness("angle", True, ANGLES, with_noise(part))
    assert found.startswith("a part of the turn that rubs at ")
    assert float(found.split()[-2]) == pytest.approx(0.4, abs=0.1)


def test_even_friction_is_like_dry_friction():
    assert likeness("angle", True, ANGLES, with_noise(np.ones(120))) == "dry friction over the whole turn"


@pytest.mark.parametrize(
    ("torque", "words"),
    [(-SPEEDS, "viscous friction"), (-np.tanh(SPEEDS / 0.1), "dry friction"), (-SPEEDS * np.abs(SPEEDS), "drag")],
    ids=["viscous", "dry", "drag"],
)
def test_a_torque_over_the_speed_is_like(torque, words):
    assert likeness("speed", False, SPEEDS, with_noise(torque)) == words


def test_what_is_like_nothing_known_has_no_likeness():
    assert likeness("angle", False, ANGLES, np.random.default_rng(0).normal(size=120)) == ""
