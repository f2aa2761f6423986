# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes that the catalogue lacks are recognised in nonparametric torques."""

import numpy as np
import pytest

from cdp_ident.tracing.found_effects import likeness

ANGLES = np.linspace(-1.5, 1.8, 120)


def with_noise(torque):
    return torque + np.random.default_rng(0).normal(scale=0.05 * np.sqrt(np.mean(torque**2)), size=len(torque))


def test_a_wave_once_a_turn_is_like_an_unbalance():
    assert likeness("angle", False, ANGLES, with_noise(0.1 * np.sin(ANGLES + 0.4))) == "an unbalance"


def test_friction_over_a_part_of_the_turn_is_like_a_part_that_rubs():
    part = (np.abs(ANGLES - 0.4) < 0.3).astype(float)
    found = likeness("angle", True, ANGLES, with_noise(part))
    assert found.startswith("a part of the turn that rubs at ")
    assert float(found.split()[-2]) == pytest.approx(0.4, abs=0.1)


@pytest.mark.parametrize(
    ("over", "dry", "torque"),
    [
        ("angle", True, np.ones(120)),
        ("angle", False, 0.1 * np.sin(5.0 * ANGLES + 0.4)),
        ("speed", False, -ANGLES),
        ("angle", False, np.random.default_rng(0).normal(size=120)),
    ],
    ids=["even friction", "cogging", "viscous friction", "noise"],
)
def test_what_the_catalogue_has_an_effect_for_and_what_is_like_nothing_known_has_no_likeness(over, dry, torque):
    assert likeness(over, dry, ANGLES, with_noise(torque)) == ""
