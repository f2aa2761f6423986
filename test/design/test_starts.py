# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The best of the starts that a hand can lead both rods to."""

import numpy as np
import pytest

from cdp_ident.design.starts import HAND, Grid, survey
from cdp_ident.errors import IdentificationError


def test_half_a_turn_to_one_side_is_half_a_turn_to_the_other():
    grid = Grid.of(90.0)
    assert np.degrees(grid.inner) == pytest.approx([-90, 0, 90, 180])


def test_every_second_angle_is_left_of_a_thinned_grid_and_hanging_among_them():
    grid = Grid.of(45.0, most_outer=90.0).thinned
    assert np.degrees(grid.inner) == pytest.approx([-90, 0, 90, 180])
    assert np.degrees(grid.outer) == pytest.approx([-90, 0, 90])
    few = Grid.of(30.0, most_inner=30.0)
    assert np.array_equal(few.thinned.inner, few.inner)


def test_no_rod_is_led_further_than_is_said():
    grid = Grid.of(30.0, most_inner=60.0, most_outer=170.0)
    assert np.degrees(grid.inner) == pytest.approx([-60, -30, 0, 30, 60])
    assert np.degrees(grid.outer[[0, -1]]) == pytest.approx([-150, 150])


def test_angles_are_from_hanging():
    trial = Grid.of(90.0).trial(1, 2)
    assert (trial.theta1, trial.theta2) == (pytest.approx(np.pi), pytest.approx(1.5 * np.pi))


def test_the_start_with_the_smallest_loss_is_found():
    found = survey(lambda t: (t.theta1 - np.pi - 1.0) ** 2 + (t.theta2 - np.pi + 0.5) ** 2, Grid.of(15.0))
    assert np.degrees([found.inner, found.outer]) == pytest.approx([60, -30])
    assert found.losses.shape == (24, 24)
    assert found.expected <= found.worst
    assert (found.trial.theta1, found.trial.theta2) == (
        pytest.approx(np.pi + found.inner),
        pytest.approx(np.pi + found.outer),
    )


def test_a_start_that_is_good_at_one_point_alone_is_no_advice():
    def loss(trial):
        spike = abs(trial.theta1 - np.pi - np.radians(90)) < np.radians(HAND) / 2 and abs(trial.theta2 - np.pi) < 0.01
        return 0.0 if spike else 1.0 + (trial.theta1 - np.pi) ** 2

    found = survey(loss, Grid.of(30.0))
    assert found.inner == 0.0
    assert found.losses.min() == 0.0


def test_starts_whose_motion_cannot_be_computed_are_not_taken():
    found = survey(lambda t: np.inf if t.theta1 < np.pi + 0.6 else t.theta1, Grid.of(30.0))
    assert found.inner > 0.6


def test_where_no_start_can_be_computed_none_is_advised():
    with pytest.raises(IdentificationError, match="from no start"):
        survey(lambda trial: np.inf, Grid.of(90.0))
