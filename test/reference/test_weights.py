# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rod with a weight on it, held against the weight as a point that moves with the rod."""

import numpy as np
import pytest

from reference.pendulum import TABLE_5, energy
from reference.weights import with_weight

MASS, PLACE, INERTIA = 0.05, 0.3, 2e-5
STATES = np.random.default_rng(0).uniform(-4.0, 4.0, (20, 4))


def energy_of_weight(rod):
    theta1, theta2, omega1, omega2 = STATES.T
    if rod == "inner":
        speed = np.array([PLACE * np.cos(theta1) * omega1, -PLACE * np.sin(theta1) * omega1])
        height, turns = PLACE * np.cos(theta1), omega1
    else:
        length = TABLE_5["L"]
        speed = np.array(
            [
                length * np.cos(theta1) * omega1 + PLACE * np.cos(theta2) * omega2,
                -length * np.sin(theta1) * omega1 - PLACE * np.sin(theta2) * omega2,
            ]
        )
        height, turns = length * np.cos(theta1) + PLACE * np.cos(theta2), omega2
    return 0.5 * MASS * np.sum(speed**2, axis=0) + 0.5 * INERTIA * turns**2 + MASS * TABLE_5["g"] * height


@pytest.mark.parametrize("rod", ["inner", "outer"])
def test_a_rod_with_a_weight_has_the_energy_of_both(rod):
    both = energy(with_weight(TABLE_5, rod, MASS, PLACE, INERTIA), STATES)
    assert both == pytest.approx(energy(TABLE_5, STATES) + energy_of_weight(rod), rel=1e-12)
